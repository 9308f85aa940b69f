// bench/instrument/page_assets.h: the style and the script of pages, which CMake makes part of the
// program.
#pragma once

#include <string_view>

namespace plait::instrument {

extern const std::string_view kPageStyle;   ///< instrument/page/style.css
extern const std::string_view kPageScript;  ///< instrument/page/sort_tables.js

}  // namespace plait::instrument
