// bench/instrument/figure_text.h: figures as text, the same in every report.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "instrument/statistics.h"

namespace plait::instrument {

/// "1.25 s", "3.20 ms", "12.0 us".
std::string seconds_text(double seconds);
/// "8:27", "1:55:24".
std::string clock_text(double seconds);

/// {value, low, high, confidence, count}.
nlohmann::ordered_json to_json(const Estimate& estimate);

/// Without what moves a terminal's cursor: names come from foreign files.
std::string printable(std::string text);
/// Characters of UTF-8.
std::size_t width_of(const std::string& text);
/// At most `most` characters of UTF-8, the last one "…" where some are left out. REQUIRES: most >
/// 0.
std::string shortened(const std::string& text, std::size_t most);
/// Lines of at most `width` characters of UTF-8, broken between words; each line but the first
/// begins with `indent`.
std::string wrapped(const std::string& text, std::size_t width, const std::string& indent = "");

}  // namespace plait::instrument
