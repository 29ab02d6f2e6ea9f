//! Reading flowchart programs: spellings, faults, detection.
