//! The memory, held to closed forms, to a checker that knows the rules by itself, and to a simulator from outside.

mod checker;
mod closed_forms;
mod configs;
mod faults;
mod judge;
mod pairs;
mod policies;
mod traffic;
