// CMake needs a source for a target whose precompiled headers others reuse.
