//! trunnion
