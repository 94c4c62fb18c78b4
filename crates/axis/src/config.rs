//! Description of an axis, as machine files hold it.

/// placeholder for the axis helper
#[derive(Clone, Debug)]
pub struct AxisConfig {}
