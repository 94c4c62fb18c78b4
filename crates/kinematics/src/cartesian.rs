//! cartesian
