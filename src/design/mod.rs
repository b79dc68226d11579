//! The freeform prism, designed from a camera and a virtual camera.
