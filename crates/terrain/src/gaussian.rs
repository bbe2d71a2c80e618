//! Gaussian hills and hollows (Sakamoto & Kubota 2022, eq. 7).

/// One hill, h(r) = a·exp(−r²/2σ²); a hollow if its amplitude is negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    /// Centre (x, y) in metres from the middle of cell (0, 0).
    pub centre_m: [f64; 2],
    /// Standard deviation σ, metres, above 0.
    pub sigma_m: f64,
    /// Height of the top, metres.
    pub amplitude_m: f64,
}

impl Gaussian {
    /// Height at `at_m`, metres.
    #[must_use]
    pub fn height_m(&self, at_m: [f64; 2]) -> f64 {
        let [dx, dy] = self.offset(at_m);
        self.amplitude_m * libm::exp(-(dx * dx + dy * dy) / (2.0 * self.sigma_m * self.sigma_m))
    }

    /// Gradient at `at_m`, the derivative of [`Gaussian::height_m`]: −(x − c)/σ² · h.
    #[must_use]
    pub fn gradient(&self, at_m: [f64; 2]) -> [f64; 2] {
        self.height_and_gradient(at_m).1
    }

    /// [`Gaussian::height_m`] and [`Gaussian::gradient`] together, for the price of one exponential.
    #[must_use]
    pub fn height_and_gradient(&self, at_m: [f64; 2]) -> (f64, [f64; 2]) {
        let [dx, dy] = self.offset(at_m);
        let height_m = self.height_m(at_m);
        let steepening = -height_m / (self.sigma_m * self.sigma_m);
        (height_m, [dx * steepening, dy * steepening])
    }

    fn offset(&self, at_m: [f64; 2]) -> [f64; 2] {
        [at_m[0] - self.centre_m[0], at_m[1] - self.centre_m[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn height_at_the_centre_is_the_amplitude_and_falls_as_the_closed_form() {
        let hill = Gaussian { centre_m: [3.0, -1.0], sigma_m: 2.0, amplitude_m: 0.5 };
        assert_eq!(hill.height_m([3.0, -1.0]), 0.5);
        assert!((hill.height_m([5.0, -1.0]) - 0.5 * libm::exp(-0.5)).abs() < 1e-15, "one sigma away");
    }

    #[test]
    fn the_gradient_is_the_derivative_of_the_height() {
        let hill = Gaussian { centre_m: [1.0, 2.0], sigma_m: 1.5, amplitude_m: -0.3 };
        for at in [[0.0, 0.0], [1.0, 2.0], [2.5, 0.7]] {
            let step = 1e-5;
            let numeric = [
                (hill.height_m([at[0] + step, at[1]]) - hill.height_m([at[0] - step, at[1]])) / (2.0 * step),
                (hill.height_m([at[0], at[1] + step]) - hill.height_m([at[0], at[1] - step])) / (2.0 * step),
            ];
            let analytic = hill.gradient(at);
            for axis in 0..2 {
                assert!((numeric[axis] - analytic[axis]).abs() < 1e-9, "{numeric:?} {analytic:?}");
            }
        }
    }
}
