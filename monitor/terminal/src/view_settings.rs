//! What the user has chosen to see.

use contract::{Brief, Decision};

use report::Layer;

/// What the user has chosen to see.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct ViewSettings {
    /// Decision to look back at; `None` follows the mission.
    pub at: Option<Decision>,
    /// Whether to show the policy if the planner in command has one.
    pub policy: bool,
    /// Whether to show the map around the hopper, one cell per character pair, rather than all of it.
    pub follow: bool,
    /// Whether orders are allowed.
    pub control: bool,
    /// Whether to show what each key does.
    pub keys: bool,
    /// What the ground shows; `None` shows what suits the mission.
    pub layer: Option<Layer>,
}

impl ViewSettings {
    /// The decision that is shown if decision `due` is due.
    #[must_use]
    pub fn shown(&self, due: Decision) -> Decision {
        self.at.map_or(due, |at| at.min(due))
    }

    /// Back by one: from the keys to the mission, from an earlier hop to now.
    pub fn back(&mut self) {
        if self.keys {
            self.keys = false;
        } else {
            self.at = None;
        }
    }

    /// The layer that is shown: the chosen one if the mission has it, otherwise [`Layer::first`].
    #[must_use]
    pub fn layer(&self, brief: &Brief) -> Layer {
        let suits = |layer: &Layer| Layer::of(brief).contains(layer);
        self.layer.filter(suits).unwrap_or_else(|| Layer::first(brief))
    }

    /// Goes on to the next layer that the mission has.
    pub fn next_layer(&mut self, brief: &Brief) {
        let layers = Layer::of(brief);
        let at = layers.iter().position(|layer| *layer == self.layer(brief)).unwrap_or(0);
        self.layer = Some(layers[(at + 1) % layers.len()]);
    }

    /// Moves by `by` hops, back if negative; at the end of the history the view follows the mission again.
    pub fn go(&mut self, by: i64, due: Decision) {
        let to = self.shown(due).0.saturating_add_signed(by);
        self.at = (to < due.0).then_some(Decision(to));
    }
}
