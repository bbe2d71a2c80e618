//! The file that takes a browser to an address with a key.

use std::io::Write;
use std::path::Path;

use tempfile::NamedTempFile;

/// A page of HTML that goes on to an address at once. Only its owner can read it; it is removed with this value.
#[derive(Debug)]
pub struct RedirectFile(NamedTempFile);

impl RedirectFile {
    /// Writes the file to the folder of this user's session, or to that of temporary files.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(url: &str) -> std::io::Result<Self> {
        let session = std::env::var_os("XDG_RUNTIME_DIR").map(std::path::PathBuf::from);
        let folder = match session {
            Some(folder) if folder.is_dir() => folder,
            _ => std::env::temp_dir(),
        };
        // Made with mode 600, under a name that nobody has made before.
        let mut file = tempfile::Builder::new().prefix("hopper-page-").suffix(".html").tempfile_in(folder)?;
        file.write_all(redirect(url).as_bytes())?;
        file.flush()?;
        Ok(Self(file))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.0.path()
    }
}

/// Replaces this page in the history of the browser, and gives no referrer.
fn redirect(url: &str) -> String {
    format!(
        "<!doctype html>\n<meta charset=\"utf-8\">\n<meta name=\"referrer\" content=\"no-referrer\">\n\
         <title>Hopper</title>\n<script>location.replace(\"{url}\")</script>\n\
         <noscript><meta http-equiv=\"refresh\" content=\"0; url={url}\"></noscript>\n\
         <a href=\"{url}\">Open the page</a>\n"
    )
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    /// P-WEB-OPEN.
    #[test]
    fn only_the_owner_reads_the_file_and_it_goes_with_its_value() {
        let file = RedirectFile::write("http://127.0.0.1:1/#key=0").unwrap();
        let path = file.path().to_owned();
        assert_eq!(path.metadata().unwrap().permissions().mode() & 0o777, 0o600);
        assert!(std::fs::read_to_string(&path).unwrap().contains("http://127.0.0.1:1/#key=0"));
        drop(file);
        assert!(!path.exists());
    }
}
