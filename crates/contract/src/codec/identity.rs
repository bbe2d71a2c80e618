//! Runs, robots and names.

use super::{Codec, Ends};
use crate::field::Meaning;
use crate::{Name, Refusal, RobotId, RunId};

/// A run nonce as two halves, the high one first.
pub(crate) struct Run;

/// The run that a message belongs to.
pub(crate) const RUN: Run = Run;

impl Codec<[u64; 2]> for Run {
    type Value = RunId;

    #[inline]
    fn to_wire(&self, run: &RunId) -> [u64; 2] {
        [(run.0 >> 64) as u64, run.0 as u64]
    }

    #[inline]
    fn from_wire(&self, _: &str, [high, low]: [u64; 2]) -> Result<RunId, Refusal> {
        Ok(RunId(u128::from(high) << 64 | u128::from(low)))
    }

    fn range(&self) -> String {
        "any; high half first".into()
    }
}

/// The number of a robot.
pub(crate) struct Robot;

/// The number of a robot, which its reader compares with those of the mission.
pub(crate) const ROBOT: Robot = Robot;

impl Codec<u32> for Robot {
    type Value = RobotId;

    #[inline]
    fn to_wire(&self, robot: &RobotId) -> u32 {
        robot.0.into()
    }

    #[inline]
    fn from_wire(&self, _: &str, wire: u32) -> Result<RobotId, Refusal> {
        u16::try_from(wire).map(RobotId).map_err(|_| Refusal::WrongRobot { robots: u16::MAX, got: wire })
    }

    fn range(&self) -> String {
        format!("at most {}", u16::MAX)
    }

    fn ends(&self) -> Ends<u32> {
        Ends { inside: vec![0, u16::MAX.into()], outside: vec![u32::from(u16::MAX) + 1] }
    }
}

/// A name, zero-padded.
pub(crate) struct ShortName {
    may_be_empty: bool,
}

/// A name, or none.
pub(crate) const NAME: ShortName = ShortName { may_be_empty: true };

/// A name that must be given.
pub(crate) const GIVEN_NAME: ShortName = ShortName { may_be_empty: false };

impl Codec<[u8; Name::BYTES]> for ShortName {
    type Value = Name;

    fn to_wire(&self, name: &Name) -> [u8; Name::BYTES] {
        name.bytes()
    }

    fn from_wire(&self, field: &str, wire: [u8; Name::BYTES]) -> Result<Name, Refusal> {
        let name =
            Name::from_bytes(wire).map_err(|error| Refusal::malformed(field, &self.range(), error.got))?;
        if name == Name::NONE && !self.may_be_empty {
            return Err(Refusal::malformed(field, "a name", "nothing"));
        }
        Ok(name)
    }

    fn range(&self) -> String {
        let empty = if self.may_be_empty { "" } else { ", not empty" };
        let most = Name::BYTES - 1;
        format!("at most {most} letters, digits or `._-+`, not beginning with a dot{empty}, then zeros")
    }

    fn meaning(&self) -> Meaning {
        Meaning::Text
    }

    fn ends(&self) -> Ends<[u8; Name::BYTES]> {
        let of = |first| std::array::from_fn(|at| if at == 0 { first } else { 0 });
        let mut ends = Ends {
            inside: vec![of(b'a'), of(b'+')],
            outside: vec![of(b'.'), of(b'/'), of(0x80), [b'a'; Name::BYTES]],
        };
        if self.may_be_empty { &mut ends.inside } else { &mut ends.outside }.push([0; Name::BYTES]);
        ends
    }
}
