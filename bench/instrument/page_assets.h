// bench/instrument/page_assets.h: the style of pages, which CMake makes part of the program.
#pragma once

#include <string_view>

namespace plait::instrument {

extern const std::string_view kPageStyle;  ///< instrument/page/style.css

}  // namespace plait::instrument
