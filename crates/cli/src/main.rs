//! The lostmotion command line.
fn main() {}
