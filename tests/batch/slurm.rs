//! A Slurm of one node, this machine, in a folder of its own: daemons of the caller, no service of the system.

use std::fs;
use std::io::Read as _;
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;
use std::process::Command;
use std::thread::{available_parallelism, sleep};
use std::time::{Duration, Instant};

use rustix::process::Signal;

use crate::harness::{PATIENCE, Process, stderr};

/// The daemons that are running; dropping it ends them.
pub struct Slurm {
    /// In the order in which they end: node, controller, authentication.
    daemons: Vec<Process>,
    dir: tempfile::TempDir,
}

impl Slurm {
    /// Starts munged, slurmctld and slurmd, or says why they cannot run here.
    pub fn start() -> Result<Self, String> {
        let (munged, slurmctld, slurmd) = (program("munged")?, program("slurmctld")?, program("slurmd")?);
        program("sbatch")?;
        let dir = tempfile::tempdir().unwrap();
        fs::set_permissions(dir.path(), fs::Permissions::from_mode(0o755)).unwrap();
        let mut slurm = Self { daemons: Vec::new(), dir };
        for folder in ["munge", "state", "spool"] {
            fs::create_dir(slurm.path(folder)).unwrap();
        }
        let key = slurm.path("munge.key");
        let mut secret = [0; 64];
        fs::File::open("/dev/urandom").unwrap().read_exact(&mut secret).unwrap();
        fs::write(&key, secret).unwrap();
        fs::set_permissions(&key, fs::Permissions::from_mode(0o600)).unwrap();
        fs::write(slurm.configuration(), slurm.settings()).unwrap();

        let mut command = Command::new(munged);
        // --force: a folder that others may write, such as /tmp, above the socket is a warning.
        command.args(["--foreground", "--force"]);
        for (option, file) in [
            ("key-file", "munge.key"),
            ("socket", "munge/socket"),
            ("pid-file", "munge/pid"),
            ("log-file", "munge/log"),
            ("seed-file", "munge/seed"),
        ] {
            command.arg(format!("--{option}={}", slurm.path(file).display()));
        }
        slurm.daemon("munged", command);
        slurm.await_that("munged to listen", |slurm| slurm.path("munge/socket").exists())?;
        for (role, program) in [("slurmctld", slurmctld), ("slurmd", slurmd)] {
            let mut command = Command::new(program);
            command.arg("-D").env("SLURM_CONF", slurm.configuration());
            slurm.daemon(role, command);
        }
        slurm.await_that("the node to be idle", |slurm| {
            let output = slurm.command("sinfo", &["--noheader", "--format=%T"]).output().unwrap();
            output.stdout.starts_with(b"idle")
        })?;
        Ok(slurm)
    }

    /// The path of slurm.conf.
    pub fn configuration(&self) -> String {
        self.path("slurm.conf").display().to_string()
    }

    /// What a command of Slurm prints; it must succeed.
    pub fn run(&self, program: &str, words: &[&str]) -> String {
        let output = self.command(program, words).output().unwrap();
        assert!(output.status.success(), "{program} {words:?}: {}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    /// Waits until no task of a job is left, and requires that all succeeded.
    pub fn await_end(&mut self, job: &str) {
        let words = ["--noheader", "--states=all", "--array", "--format=%T", "--job", job];
        let waited =
            self.await_that("the job to end", |slurm| slurm.run("squeue", &words[..]).lines().all(is_end));
        let states = self.run("squeue", &words);
        assert!(waited.is_ok() && states.lines().all(|state| state == "COMPLETED"), "{waited:?}: {states}");
    }

    fn settings(&self) -> String {
        let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap();
        let host = host.trim().split('.').next().unwrap();
        let user = rustix::process::geteuid().as_raw();
        // As many ports as daemons, all bound at once so that they differ.
        let ports: [TcpListener; 2] = std::array::from_fn(|_| TcpListener::bind("127.0.0.1:0").unwrap());
        let [controller, node] = ports.map(|port| port.local_addr().unwrap().port());
        let dir = self.dir.path().display();
        // The array asks for two processors; a machine with one is said to have two.
        let processors = available_parallelism().map_or(2, usize::from).max(2);
        format!(
            "ClusterName=hopper\n\
             SlurmctldHost={host}(127.0.0.1)\n\
             SlurmUser={user}\n\
             SlurmdUser={user}\n\
             AuthType=auth/munge\n\
             AuthInfo=socket={dir}/munge/socket,cred_expire=5\n\
             SlurmctldPort={controller}\n\
             SlurmdPort={node}\n\
             StateSaveLocation={dir}/state\n\
             SlurmdSpoolDir={dir}/spool\n\
             SlurmctldPidFile={dir}/slurmctld.pid\n\
             SlurmdPidFile={dir}/slurmd.pid\n\
             # Without control groups, which a container has no right to.\n\
             ProctrackType=proctrack/linuxproc\n\
             TaskPlugin=task/none\n\
             SelectType=select/cons_tres\n\
             SelectTypeParameters=CR_CPU\n\
             AccountingStorageType=accounting_storage/none\n\
             MpiDefault=none\n\
             SlurmdParameters=config_overrides\n\
             NodeName={host} NodeAddr=127.0.0.1 CPUs={processors}\n\
             PartitionName=all Nodes={host} Default=YES State=UP\n"
        )
    }

    fn daemon(&mut self, role: &str, command: Command) {
        self.daemons.insert(0, Process::spawn(role, command, self.dir.path()));
    }

    fn command(&self, program: &str, words: &[&str]) -> Command {
        let mut command = Command::new(program);
        command.args(words).env("SLURM_CONF", self.configuration());
        command
    }

    fn path(&self, file: &str) -> PathBuf {
        self.dir.path().join(file)
    }

    /// Waits until `claim` holds; if it does not, what the daemons wrote.
    fn await_that(&mut self, what: &str, claim: impl Fn(&Self) -> bool) -> Result<(), String> {
        let since = Instant::now();
        while !claim(self) {
            for daemon in &mut self.daemons {
                let ended = daemon.has_ended().map(|status| status.to_string());
                let late = since.elapsed() > PATIENCE;
                if let Some(how) = ended.or(late.then(|| format!("waited {PATIENCE:?}"))) {
                    return Err(format!("{what}: {} {how}\n{}", daemon.role, daemon.log()));
                }
            }
            sleep(Duration::from_millis(100));
        }
        Ok(())
    }
}

impl Drop for Slurm {
    fn drop(&mut self) {
        // Jobs are children of the node's, not of ours.
        let _ = self.command("scancel", &["--me", "--full"]).output();
        for daemon in &mut self.daemons {
            if daemon.has_ended().is_none() {
                daemon.signal(Signal::TERM);
                daemon.code();
            }
        }
    }
}

/// The path of a program, also of one in a folder that only the path of root has.
fn program(name: &str) -> Result<PathBuf, String> {
    let path = std::env::var("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&path).chain(["/usr/sbin".into()]);
    let mut files = folders.map(|folder| folder.join(name));
    files.find(|file| file.is_file()).ok_or(format!("{name} is not installed"))
}

/// Whether a task in this state, as squeue names it, will not change any more.
fn is_end(state: &str) -> bool {
    !["PENDING", "RUNNING", "COMPLETING", "CONFIGURING", "REQUEUED"].contains(&state)
}
