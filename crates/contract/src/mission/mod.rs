//! What a mission is about, before it begins: its brief with its robots, and how time passes in it.

pub mod account;
pub mod body;
pub mod brief;
pub mod goal;
pub mod kind;
pub mod leg;
pub mod motion_table;
pub mod pace;
pub mod reading;
pub mod robot;
pub mod sampling;
pub mod sensor;
