//! The glTF reader: one small file made in code for each behaviour, rubbish, and the real scenes where they are there.

mod animation;
mod build;
mod errors;
mod looks;
mod rubbish;
mod scenes;
mod shape;
