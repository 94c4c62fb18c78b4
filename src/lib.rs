//! lostmotion
