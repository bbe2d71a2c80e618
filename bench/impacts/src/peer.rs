//! The same impacts by Rapier: one step of a world in which each sphere touches the plane.

use nalgebra::Vector3;
use rapier3d_f64::dynamics::FrictionModel;
use rapier3d_f64::prelude::*;

use crate::case::{After, BODY, Case};

/// Length of the step, seconds.
const STEP_S: f64 = 1e-4;

/// Distance between two spheres, metres: they do not meet.
const APART_M: f64 = 1.0;

/// A world with a sphere for each case.
pub struct Peer {
    world: PhysicsWorld,
    spheres: Vec<RigidBodyHandle>,
}

impl Peer {
    /// Solved with that many iterations a step.
    #[must_use]
    pub fn new(cases: &[Case], iterations: usize) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::ZERO;
        world.integration_parameters.dt = STEP_S;
        world.integration_parameters.num_solver_iterations = iterations;
        world.integration_parameters.friction_model = FrictionModel::Coulomb;
        // The larger of both coefficients counts, and the plane has none.
        let plane = ColliderBuilder::new(SharedShape::halfspace(Vector::Z)).friction(0.0).restitution(0.0);
        world.insert_collider(plane, None);
        let side = (cases.len() as f64).sqrt().ceil() as usize;
        let sphere = |(number, case): (usize, &Case)| {
            let at = |index: usize| index as f64 * APART_M;
            let body = RigidBodyBuilder::dynamic()
                .translation(Vector::new(at(number % side), at(number / side), BODY.radius_m))
                .can_sleep(false);
            let inertia = BODY.inertia * BODY.radius_m * BODY.radius_m;
            let collider = ColliderBuilder::ball(BODY.radius_m)
                .mass_properties(MassProperties::new(Vector::ZERO, 1.0, Vector::splat(inertia)))
                .friction(case.friction)
                .friction_combine_rule(CoefficientCombineRule::Max)
                .restitution(case.restitution)
                .restitution_combine_rule(CoefficientCombineRule::Max);
            world.insert(body, collider).0
        };
        let spheres = cases.iter().enumerate().map(sphere).collect();
        let mut peer = Self { world, spheres };
        peer.set(cases);
        peer
    }

    fn set(&mut self, cases: &[Case]) {
        let vector = |of: Vector3<f64>| Vector::new(of.x, of.y, of.z);
        for (handle, case) in self.spheres.iter().zip(cases) {
            let sphere = &mut self.world.bodies[*handle];
            sphere.set_linvel(vector(case.velocity), true);
            sphere.set_angvel(vector(case.spin), true);
        }
    }

    /// All impacts at once.
    pub fn step(&mut self) -> Vec<After> {
        self.world.step();
        let vector = |of: Vector| Vector3::new(of.x, of.y, of.z);
        let after = |handle: &RigidBodyHandle| {
            let sphere = &self.world.bodies[*handle];
            [vector(sphere.linvel()), vector(sphere.angvel())]
        };
        self.spheres.iter().map(after).collect()
    }
}
