//! The module as JavaScript sees it: numbers in and out, text and bytes through two buffers.
//!
//! A caller asks for room with [`input`], fills it, and calls a function, whose text is then at [`output`]. A function
//! returns the length of its text, or minus the length of the text of an error.

use std::cell::{OnceCell, RefCell};
use std::sync::Arc;

use contract::{Cell, Decision, MonotonicNs};
use monitor::web::order::order as parsed;
use serde::Deserialize;
use serde_json::json;

use crate::{Request, Session, fly as flown};

#[link(wasm_import_module = "host")]
unsafe extern "C" {
    /// Milliseconds since any moment; never goes back.
    safe fn now_ms() -> f64;
    /// Shows what a panic says, before the module traps.
    fn panicked(text: *const u8, length: usize);
}

#[derive(Default)]
struct Module {
    input: Vec<u8>,
    output: Vec<u8>,
    /// The elevation model handed over last.
    ground: Option<Arc<[u8]>>,
    session: Option<Session>,
}

thread_local! {
    static MODULE: RefCell<Module> = RefCell::default();
    static HOOK: OnceCell<()> = const { OnceCell::new() };
}

fn now() -> MonotonicNs {
    MonotonicNs((now_ms() * 1e6) as u64)
}

impl Module {
    fn ground(&self) -> Arc<[u8]> {
        self.ground.clone().unwrap_or_else(|| Arc::from([]))
    }

    fn request(&self) -> Result<Request, String> {
        serde_json::from_slice(&self.input)
            .map_err(|error| format!("a mission is asked for in JSON: {error}"))
    }

    fn session(&mut self) -> Result<&mut Session, String> {
        self.session.as_mut().ok_or_else(|| "no mission has begun".into())
    }
}

/// Runs `act` on the module and keeps its text for [`output`].
fn answer(act: impl FnOnce(&mut Module) -> Result<String, String>) -> i32 {
    MODULE.with_borrow_mut(|module| {
        let (text, sign) = match act(module) {
            Ok(text) => (text, 1),
            Err(error) => (error, -1),
        };
        module.output = text.into_bytes();
        sign * i32::try_from(module.output.len()).unwrap_or(i32::MAX)
    })
}

/// Room for `length` bytes, which the caller fills before its next call.
#[unsafe(no_mangle)]
extern "C" fn input(length: usize) -> *mut u8 {
    HOOK.with(|hook| {
        hook.get_or_init(|| {
            std::panic::set_hook(Box::new(|info| {
                let text = info.to_string();
                // SAFETY: the text lives until the call returns, and the host copies it.
                unsafe { panicked(text.as_ptr(), text.len()) };
            }));
        });
    });
    MODULE.with_borrow_mut(|module| {
        module.input = vec![0; length];
        module.input.as_mut_ptr()
    })
}

/// Where the text of the last call is.
#[unsafe(no_mangle)]
extern "C" fn output() -> *const u8 {
    MODULE.with_borrow(|module| module.output.as_ptr())
}

/// Takes the input as an elevation model, for the missions that are asked for after it.
#[unsafe(no_mangle)]
extern "C" fn ground() -> i32 {
    answer(|module| {
        module.ground = Some(std::mem::take(&mut module.input).into());
        Ok(String::new())
    })
}

/// Names and first sentences of the built-in scenarios with the elevation models that they need, and the profiles.
#[unsafe(no_mangle)]
extern "C" fn choices() -> i32 {
    answer(|_| {
        let ground = |text: &str| {
            let after = text.split_once("elevation_file]")?.1.split_once("file = \"")?.1;
            Some(after.split_once('"')?.0.to_owned())
        };
        let scenarios = scenario::BUILT_IN.map(
            |(name, text)| json!({ "name": name, "is": scenario::description(text), "ground": ground(text) }),
        );
        let profiles = contract::Profile::ALL.map(|profile| profile.to_string());
        let dynamics: Vec<_> = contract::MotionModel::ALL.iter().map(ToString::to_string).collect();
        Ok(json!({ "scenarios": scenarios, "profiles": profiles, "dynamics": dynamics }).to_string())
    })
}

/// Flies the mission that the input asks for to its end; tells its outcome.
#[unsafe(no_mangle)]
extern "C" fn fly() -> i32 {
    answer(|module| {
        let outcome = flown(&module.request()?, &module.ground())?;
        serde_json::to_string(&outcome).map_err(|error| error.to_string())
    })
}

/// Begins the mission that the input asks for, in place of the one before.
#[unsafe(no_mangle)]
extern "C" fn begin() -> i32 {
    answer(|module| {
        let session = Session::begin(&module.request()?, &module.ground(), Box::new(now))?;
        let text = json!({ "planners": session.suited(), "warnings": session.warnings() }).to_string();
        module.session = Some(session);
        Ok(text)
    })
}

/// Lets every process take its turn; tells the decision that is due, and whether the mission is over.
#[unsafe(no_mangle)]
extern "C" fn turn() -> i32 {
    answer(|module| {
        let session = module.session()?;
        let over = session.turn()?;
        Ok(json!({ "decision": session.decision().0, "over": over, "digest": session.digest() }).to_string())
    })
}

/// The next frames for the page, an event and its JSON a line.
#[unsafe(no_mangle)]
extern "C" fn frames() -> i32 {
    /// Enough for one message to the page.
    const BYTES: usize = 1 << 18;
    answer(|module| {
        let session = module.session()?;
        let mut text = String::new();
        while text.len() < BYTES {
            let Some(frame) = session.frame(now()) else { break };
            text += &format!("{} {}\n", frame.event, frame.data);
        }
        Ok(text)
    })
}

/// Has the next frames begin anew.
#[unsafe(no_mangle)]
extern "C" fn rewind() -> i32 {
    answer(|module| {
        module.session()?.rewind();
        Ok(String::new())
    })
}

/// Whether policies are among the frames.
#[unsafe(no_mangle)]
extern "C" fn follow_policies(wanted: i32) -> i32 {
    answer(|module| {
        module.session()?.follow_policies(wanted != 0);
        Ok(String::new())
    })
}

/// Why a hop from a cell at a decision, as the page's server would answer.
#[unsafe(no_mangle)]
extern "C" fn why() -> i32 {
    #[derive(Deserialize)]
    struct Question {
        x: i32,
        y: i32,
        at: u64,
    }
    answer(|module| {
        let Question { x, y, at } =
            serde_json::from_slice(&module.input).map_err(|error| error.to_string())?;
        Ok(module.session()?.history().reason_json(Cell::new(x, y), Decision(at)))
    })
}

/// Carries out the order in the input, in the words of the page.
#[unsafe(no_mangle)]
extern "C" fn order() -> i32 {
    answer(|module| {
        let order = parsed(&module.input)?;
        module.session()?.order(order);
        Ok("accepted".into())
    })
}

/// Has the planner that the input names command from the next decision on that nobody has commanded yet.
#[unsafe(no_mangle)]
extern "C" fn hand_over() -> i32 {
    answer(|module| {
        let name = String::from_utf8_lossy(&module.input).into_owned();
        module.session()?.hand_over(&name)?;
        Ok("accepted".into())
    })
}
