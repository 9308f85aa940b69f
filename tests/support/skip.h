// tests/support/skip.h: a test that cannot run on this machine reports that.
#pragma once

#include <string>

namespace plait::test {

/// Prints "skipped: REASON". A case or section that cannot run calls this instead of its
/// assertions; without it, a case that asserts nothing fails. If a program skips all its cases,
/// CTest reports it as "Skipped".
void skip(const std::string& reason);

}  // namespace plait::test
