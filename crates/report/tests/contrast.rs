//! Symbols stand out on any ground.

use report::colour::{BLOCKED, DARK, GOAL, HOPPER, LIGHT, NOTHING, SAND, contrast, height_rgb, rgb};

/// `share` of `over` on `under`.
fn mixed(under: [u8; 3], over: [u8; 3], share: f64) -> [u8; 3] {
    let part = |n: usize| ((1.0 - share) * f64::from(under[n]) + share * f64::from(over[n])).round() as u8;
    [part(0), part(1), part(2)]
}

/// Every colour that ground has in the page, the terminal and the pictures: heights; sand on them, as the pictures and the
/// terminal mix it; impassable ground, hatched and tinted; what nobody has seen, on light and dark themes.
fn grounds() -> Vec<[u8; 3]> {
    let heights: Vec<[u8; 3]> = (0..64).map(|n| height_rgb(f64::from(n) / 63.0)).collect();
    let mut grounds = vec![rgb(BLOCKED), rgb(NOTHING), rgb(SAND), rgb("#ffffff"), rgb("#000000")];
    for height in heights {
        grounds.push(height);
        for share in [0.4, 0.5] {
            grounds.push(mixed(height, rgb(SAND), share));
        }
        for share in [0.45, 0.75] {
            grounds.push(mixed(height, rgb(BLOCKED), share));
        }
    }
    // Themes and contrasts of the page differ; every grey stands for them.
    grounds.extend((0..=255).map(|grey| [grey; 3]));
    grounds
}

/// P-CONTRAST: Hopper and goal have, by fill or rim, a contrast of at least 3:1 to every colour of
/// ground, in page, pictures and terminal.
#[test]
fn hopper_and_goal_stand_out_on_every_ground() {
    for (symbol, parts) in [("hopper", &[HOPPER, DARK][..]), ("goal", &[GOAL, LIGHT, DARK])] {
        for ground in grounds() {
            let best = parts.iter().map(|part| contrast(rgb(part), ground)).fold(0.0, f64::max);
            assert!(best >= 3.0, "{symbol} on {ground:?}: {best:.2}");
        }
    }
    assert!((contrast([0; 3], [255; 3]) - 21.0).abs() < 1e-9);
}

/// P-CONTRAST. The pictures draw hopper and goal with fill and rim.
#[test]
fn the_pictures_symbols_have_their_rims() {
    let picture = include_str!("snapshots/picture__a_tiny_picture_stands_as_drawn.snap");
    let (before, goal) = picture.split_once(&format!("\" fill=\"{GOAL}\" stroke=\"#fff\"")).expect("a goal");
    let (_, outline) = before.rsplit_once("points=\"").expect("its outline");
    let rim = format!("points=\"{outline}\" fill=\"none\" stroke=\"{DARK}\" stroke-width=\"3.8\"");
    assert!(before.contains(&rim) && goal.starts_with(" stroke-width=\"1.8\""), "{rim}");
    assert!(picture.contains(&format!("fill=\"{HOPPER}\" stroke=\"#111\"")));
}
