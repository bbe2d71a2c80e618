//! The model of a simulation: the one place that knows which there are.

use crate::model::Model;
use crate::oracle::Oracle;
use crate::setup::{Missions, Setup};
use crate::testing_model::TestingModel;

/// The model of the missions of `setup`, before its first decision.
pub(crate) fn of(setup: &Setup) -> Box<dyn Model> {
    match setup.missions {
        Missions::Protocol => Box::new(TestingModel::begin(&setup.mission)),
        Missions::Hopper | Missions::Rovers | Missions::Scouts | Missions::Accompanied | Missions::Mixed => {
            Box::new(Oracle::begin(&setup.mission))
        }
    }
}
