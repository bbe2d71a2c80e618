//! Sensors that show what is on the way of a robot, and nothing around it.

use contract::{Camera, ErringCamera, Track};

use super::Sensor;

impl Sensor for Track {}
impl Sensor for Camera {}
impl Sensor for ErringCamera {}
