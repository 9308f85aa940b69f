// tests/backends/conformance.h: what tests of backends take from the conformance suite.
#pragma once

#include "conformance/level.h"

namespace plait::test {

using conformance::Content;
using conformance::LevelShape;
using conformance::LevelUnderTest;
using conformance::make_content;
using conformance::read_blocks;
using BackendUnderTest = conformance::Subject;

}  // namespace plait::test
