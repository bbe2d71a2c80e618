//! What a mission is about, before it begins: its brief, its task, and how time passes in it.

pub mod brief;
pub mod design;
pub mod pace;
pub mod patrol;
pub mod reading;
pub mod task;
