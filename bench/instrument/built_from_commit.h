// bench/instrument/built_from_commit.h: which version of the sources a measurement is of.
#pragma once

#include <string_view>

namespace plait::instrument {

/// The git commit of the sources that this program was built from, with "-dirty" behind it if they
/// had changes that no commit has. Empty if they were no git checkout.
std::string_view built_from_commit() noexcept;

}  // namespace plait::instrument
