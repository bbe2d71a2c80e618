//! The files of the page, part of the executable.

/// One file.
#[derive(Clone, Copy, Debug)]
pub struct Asset {
    /// Path under which it is served.
    pub path: &'static str,
    /// Its media type.
    pub kind: &'static str,
    /// Its text.
    pub text: &'static str,
}

macro_rules! assets {
    ($($path:literal $kind:literal $file:literal),* $(,)?) => {
        /// Every file; there is no other.
        pub const ASSETS: &[Asset] =
            &[$(Asset { path: $path, kind: $kind, text: include_str!(concat!("page/", $file)) }),*];
    };
}

assets! {
    "/" "text/html; charset=utf-8" "index.html",
    "/page.css" "text/css; charset=utf-8" "page.css",
    "/icon.svg" "image/svg+xml" "icon.svg",
    "/main.js" "text/javascript; charset=utf-8" "main.js",
    "/account.js" "text/javascript; charset=utf-8" "account.js",
    "/map.js" "text/javascript; charset=utf-8" "map.js",
    "/charts.js" "text/javascript; charset=utf-8" "charts.js",
    "/scale.js" "text/javascript; charset=utf-8" "scale.js",
    "/theme.js" "text/javascript; charset=utf-8" "theme.js",
}

/// The file at `path`.
#[must_use]
pub fn asset(path: &str) -> Option<&'static Asset> {
    ASSETS.iter().find(|asset| asset.path == path)
}
