//! From samples and masks to a picture.
