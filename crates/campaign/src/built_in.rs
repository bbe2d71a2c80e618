//! The campaigns that `hopper` carries with it.

/// Built-in campaigns: name and TOML text. The texts are the files of `campaigns/`.
pub const BUILT_IN: [(&str, &str); 6] = [
    ("p23-tables", include_str!("../../../campaigns/p23-tables.toml")),
    ("p23-tables-1000", include_str!("../../../campaigns/p23-tables-1000.toml")),
    ("hopper-tables-1000", include_str!("../../../campaigns/hopper-tables-1000.toml")),
    ("p23-readings", include_str!("../../../campaigns/p23-readings.toml")),
    ("hopper-scout", include_str!("../../../campaigns/hopper-scout.toml")),
    ("hopper-mdp-10000", include_str!("../../../campaigns/hopper-mdp-10000.toml")),
];
