//! The files of the page, embedded in the executable.

/// One file of the page.
#[derive(Clone, Copy, Debug)]
pub struct Asset {
    /// Path under which it is served.
    pub path: &'static str,
    /// Media type, for the Content-Type header.
    pub kind: &'static str,
    /// Contents of the file.
    pub text: &'static str,
}

macro_rules! assets {
    ($($path:literal $kind:literal $file:literal),* $(,)?) => {
        /// Every file that is served.
        pub const ASSETS: &[Asset] =
            &[$(Asset { path: $path, kind: $kind, text: include_str!(concat!("page/", $file)) }),*];
    };
}

assets! {
    "/" "text/html; charset=utf-8" "index.html",
    "/page.css" "text/css; charset=utf-8" "page.css",
    "/icon.svg" "image/svg+xml" "icon.svg",
    "/main.js" "text/javascript; charset=utf-8" "main.js",
    "/history.js" "text/javascript; charset=utf-8" "history.js",
    "/figures.js" "text/javascript; charset=utf-8" "figures.js",
    "/legend.js" "text/javascript; charset=utf-8" "legend.js",
    "/map.js" "text/javascript; charset=utf-8" "map.js",
    "/why.js" "text/javascript; charset=utf-8" "why.js",
    "/palette.js" "text/javascript; charset=utf-8" "palette.js",
    "/contours.js" "text/javascript; charset=utf-8" "contours.js",
    "/way.js" "text/javascript; charset=utf-8" "way.js",
    "/space.js" "text/javascript; charset=utf-8" "space.js",
    "/charts.js" "text/javascript; charset=utf-8" "charts.js",
    "/scale.js" "text/javascript; charset=utf-8" "scale.js",
    "/transport.js" "text/javascript; charset=utf-8" "transport.js",
    "/theme.js" "text/javascript; charset=utf-8" "theme.js",
}

/// The file served at `path`; `None` if there is none.
#[must_use]
pub fn asset(path: &str) -> Option<&'static Asset> {
    ASSETS.iter().find(|asset| asset.path == path)
}
