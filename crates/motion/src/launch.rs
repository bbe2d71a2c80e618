//! The free parabola of a launch at any angle (P22 eq. 4, made general).
//!
//! Launched with speed v at an angle η above the horizontal, a hopper is at x = v t cos η and
//! z = v t sin η − g t²/2. Without t,
//!
//! z(d) = d tan η − g d² / (2 v² cos² η).
//!
//! With the apex height α = v² sin² η / 2g this is z(d) = d tan η − (d tan η)² / 4α, and, with the square
//! completed, **z(d) = α − (d tan η − 2α)² / 4α**. P22 prints z = α − (d − 2α)² / 4α: the same at its 45°,
//! where tan η = 1, and at no other angle: taken literally at 80° it would carry the hopper 1.9 m far
//! instead of 0.34 m. The apex lies at d = 2α / tan η, the flat is reached again at twice that.

/// Speed and direction of a hopper leaving the ground, and the gravity it leaves against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Launch {
    /// Speed, m/s, above 0.
    pub speed_mps: f64,
    /// Angle above the horizontal, radians, between 0 and π/2.
    pub angle_rad: f64,
    /// Surface gravity, m/s², above 0.
    pub gravity_mps2: f64,
}

impl Launch {
    /// The launch at `angle_rad` whose speed would carry a hop at 45° `reach_m` far over the flat: v² = g d.
    ///
    /// # Panics
    /// If the reach or the gravity is not above 0, or the angle not between 0 and π/2.
    #[must_use]
    pub fn reaching(reach_m: f64, angle_rad: f64, gravity_mps2: f64) -> Self {
        assert!(
            reach_m > 0.0 && gravity_mps2 > 0.0,
            "need a reach and a gravity, got {reach_m} m, {gravity_mps2} m/s²"
        );
        let launch = Self { speed_mps: (gravity_mps2 * reach_m).sqrt(), angle_rad, gravity_mps2 };
        launch.check();
        launch
    }

    /// The same launch at another angle: the springs hold the same energy.
    #[must_use]
    pub fn at(self, angle_rad: f64) -> Self {
        Self { angle_rad, ..self }
    }

    /// Height of the apex above the launch, metres: α = v² sin² η / 2g.
    #[must_use]
    pub fn apex_height_m(&self) -> f64 {
        self.check();
        let vertical_mps = self.speed_mps * libm::sin(self.angle_rad);
        vertical_mps * vertical_mps / (2.0 * self.gravity_mps2)
    }

    /// Distance of the apex along the ground, metres: 2α / tan η.
    #[must_use]
    pub fn apex_distance_m(&self) -> f64 {
        2.0 * self.apex_height_m() / libm::tan(self.angle_rad)
    }

    /// Distance at which a flight over the flat lands, metres: v² sin 2η / g.
    #[must_use]
    pub fn flat_range_m(&self) -> f64 {
        2.0 * self.apex_distance_m()
    }

    /// Height above the launch at `distance_m` along the ground, metres; negative below it.
    #[must_use]
    pub fn height_m(&self, distance_m: f64) -> f64 {
        let (climb_m, apex_m) = (distance_m * libm::tan(self.angle_rad), self.apex_height_m());
        climb_m - climb_m * climb_m / (4.0 * apex_m)
    }

    /// Where the falling hopper is `rise_m` above its launch, metres along the ground; `None` if it never
    /// gets that high.
    #[must_use]
    pub fn landing_distance_m(&self, rise_m: f64) -> Option<f64> {
        let apex_m = self.apex_height_m();
        let share = 1.0 - rise_m / apex_m;
        (share >= 0.0).then(|| self.apex_distance_m() * (1.0 + share.sqrt()))
    }

    /// Time from the launch to `distance_m` along the ground, seconds.
    #[must_use]
    pub fn time_s(&self, distance_m: f64) -> f64 {
        self.check();
        distance_m / (self.speed_mps * libm::cos(self.angle_rad))
    }

    fn check(&self) {
        let Self { speed_mps, angle_rad, gravity_mps2 } = *self;
        assert!(
            speed_mps > 0.0
                && gravity_mps2 > 0.0
                && angle_rad > 0.0
                && angle_rad < std::f64::consts::FRAC_PI_2,
            "a launch needs speed and gravity above 0 and an angle between 0 and π/2, got {self:?}"
        );
    }
}
