//! The library's blocks keep their contracts; faults of every kind are found out.

mod blender;
mod fifo;
mod found;
mod ram;
mod sorter;
mod stream;
