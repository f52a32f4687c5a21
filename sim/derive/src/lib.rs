//! Derives for `pellucid-sim`.
