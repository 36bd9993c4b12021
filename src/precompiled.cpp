// CMake builds a precompiled header beside a source; this one has no other purpose.
