//! What holds for every scene.
use super::*;
