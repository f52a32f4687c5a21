//! The library's blocks keep their contracts; faults of every kind are found out.

mod fifo;
mod found;
mod ram;
mod stream;
