//! Waveforms of a small machine and the set-ups for viewers.

mod formats;
mod machine;
mod views;
