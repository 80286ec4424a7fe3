//! Shared test runner.
