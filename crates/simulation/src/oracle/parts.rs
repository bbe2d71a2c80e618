//! What becomes of each robot's part in the mission, and of the mission by the parts that it requires.

use contract::{Account, Cell, Goal, Standing, Status};

use super::Oracle;

/// How the goal of a robot stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Open,
    Done,
    Failed(Status),
}

impl Oracle {
    /// Whether a robot still covers ground.
    pub(super) fn is_covering(&self) -> bool {
        self.coverers.iter().any(|number| self.turns.actors[*number].is_active())
    }

    /// Whether a robot on the ground other than `number` has stopped on a cell for good.
    fn is_taken_for_good(&self, number: usize, cell: Cell) -> bool {
        let mut actors = self.turns.actors.iter().enumerate();
        actors.any(|(other, actor)| {
            let stops = actor.body().is_on_ground() && !actor.is_active();
            other != number && stops && actor.cell == cell
        })
    }

    /// Robots that cover ground and have nothing left to cover are done.
    pub(super) fn retire(&mut self) {
        let Some(covering) = &self.covering else { return };
        for (coverer, number) in self.coverers.iter().enumerate() {
            let actor = &mut self.turns.actors[*number];
            if actor.is_active() && covering.has_covered(&self.mission, coverer) {
                (actor.standing, actor.waits) = (Standing::Done, false);
            }
        }
    }

    /// What becomes of a robot where it is now, and of the ground that it closes if that is for good.
    pub(super) fn end_if_over(&mut self, number: usize, steps: u64) {
        let brief = &self.mission.brief;
        let actor = &self.turns.actors[number];
        let is_spent = actor.spent() >= brief.limits.steps_max;
        let is_limited = brief.account != Account::Hopper && !actor.robot.required;
        let stands = self.mission.terrain.ground(actor.cell).is_some_and(|ground| ground.passable);
        let mut standing = actor.standing;
        if actor.is_active() {
            if actor.body().hops() && !stands {
                standing = Standing::Stranded;
            } else if actor.goal().is_reached(self, number, steps) {
                standing = Standing::Done;
            } else if is_limited && is_spent {
                standing = actor.gave_up();
            }
        }
        // A robot that covers ground closes its cell only where it fails, which `take` sees to.
        let closes = actor.body().is_on_ground() && !actor.covers();
        let actor = &mut self.turns.actors[number];
        // Who acts no more waits for nobody.
        (actor.standing, actor.waits) = (standing, actor.waits && standing == Standing::Active);
        if closes && standing != Standing::Active {
            self.close();
            self.retire();
        }
    }

    /// A robot on the ground stays where it is for good.
    pub(super) fn close(&mut self) {
        let actors = &self.turns.actors;
        let active = self.coverers.iter().map(|number| &actors[*number]);
        let active: Vec<Cell> = active.filter(|actor| actor.is_active()).map(|actor| actor.cell).collect();
        let on_ground = actors.iter().filter(|actor| actor.body().is_on_ground());
        let closed = on_ground.filter(|actor| match actor.covers() {
            true => actor.standing == Standing::Stranded,
            false => !actor.is_active(),
        });
        let closed: Vec<Cell> = closed.map(|actor| actor.cell).collect();
        if let Some(covering) = &mut self.covering {
            covering.close(&self.mission, &active, &closed);
        }
    }

    /// How the mission stands: by the goals of the robots that it requires.
    pub(super) fn status(&self, steps: u64) -> Status {
        let actors = &self.turns.actors;
        let required = (0..actors.len()).filter(|number| actors[*number].robot.required);
        let parts: Vec<Part> = required.map(|number| self.part(number)).collect();
        let failed = parts.iter().find_map(|part| match part {
            Part::Failed(status) => Some(*status),
            Part::Open | Part::Done => None,
        });
        match failed {
            Some(status) => status,
            None if parts.iter().all(|part| *part == Part::Done) => Status::Goal,
            None if self.can_go_on(steps) => Status::Underway,
            None => Status::Deadlock,
        }
    }

    /// Whether somebody acts next, and the limits of the mission allow it.
    fn can_go_on(&self, steps: u64) -> bool {
        let brief = &self.mission.brief;
        let Some(due) = self.turns.next_actor() else { return false };
        match brief.account {
            Account::Hopper => {
                matches!(brief.robots[0].goal, Goal::Visit(_)) || steps < brief.limits.steps_max
            }
            Account::Actions | Account::ActionsWithoutWaits => {
                due.spent() < brief.limits.steps_max || !due.robot.required
            }
        }
    }

    /// How the goal of a robot stands.
    fn part(&self, number: usize) -> Part {
        let actor = &self.turns.actors[number];
        if actor.covers()
            && let Some(covering) = &self.covering
        {
            return if covering.is_all_covered(&self.mission) {
                Part::Done
            } else if self.is_covering() {
                Part::Open
            } else {
                Part::Failed(Status::Lost)
            };
        }
        let hops = actor.body().hops();
        if hops && self.mission.terrain.ground(actor.cell).is_none() {
            return Part::Failed(Status::LeftMap);
        }
        let goal = actor.goal().cell(&self.mission.brief.grid, 0);
        let is_taken = hops && goal.is_some_and(|goal| self.is_taken_for_good(number, goal));
        match actor.standing {
            Standing::Stranded => Part::Failed(Status::Lost),
            Standing::GaveUp => Part::Failed(Status::Deadlock),
            Standing::Done => Part::Done,
            Standing::Active if is_taken => Part::Failed(Status::Deadlock),
            Standing::Active => Part::Open,
        }
    }
}
