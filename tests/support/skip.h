// tests/support/skip.h: a test that cannot be run here says so.
#pragma once

#include <string>

namespace plait::test {

/// Prints "skipped: REASON". Instead of the assertions of a case or a section that cannot run: one
/// that asserts nothing fails otherwise. A program all of whose cases were skipped is "Skipped" to
/// CTest.
void skip(const std::string& reason);

}  // namespace plait::test
