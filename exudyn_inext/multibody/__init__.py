"""Bodies, springs, joints and loads among cables in compiled code: records of what Exudyn's items are."""
