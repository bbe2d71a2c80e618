//! The campaigns that `hopper` carries with it.

/// Built-in campaigns: name and TOML text. The texts are the files of `campaigns/`.
pub const BUILT_IN: [(&str, &str); 14] = [
    ("p23-tables", include_str!("../../../campaigns/p23-tables.toml")),
    ("p23-tables-1000", include_str!("../../../campaigns/p23-tables-1000.toml")),
    ("hopper-tables-1000", include_str!("../../../campaigns/hopper-tables-1000.toml")),
    ("p23-readings", include_str!("../../../campaigns/p23-readings.toml")),
    ("p23-seen-ground", include_str!("../../../campaigns/p23-seen-ground.toml")),
    ("contact", include_str!("../../../campaigns/contact.toml")),
    ("hopper-scout", include_str!("../../../campaigns/hopper-scout.toml")),
    ("p21", include_str!("../../../campaigns/p21.toml")),
    ("p21-1000", include_str!("../../../campaigns/p21-1000.toml")),
    ("p21-large", include_str!("../../../campaigns/p21-large.toml")),
    ("p21-large-200", include_str!("../../../campaigns/p21-large-200.toml")),
    ("p21-single", include_str!("../../../campaigns/p21-single.toml")),
    ("p19", include_str!("../../../campaigns/p19.toml")),
    ("hopper-mdp-10000", include_str!("../../../campaigns/hopper-mdp-10000.toml")),
];
