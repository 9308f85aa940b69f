// bench/tune/report.h: what `plait tune` found, for the terminal, as JSON, and as a page. Sentence,
// table and command are made of the same choice.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tune/tune.h"

namespace plait::tune {

/// Seconds of a full read on another disk, by one formula: the larger of the stored bytes over the
/// disk's speed, and of what reading took from the page cache here.
double read_seconds_at(const Measured& measured, double bytes_per_second);

std::string to_text(const TuneFindings& findings, const Decision& decision);
nlohmann::ordered_json to_json(const TuneFindings& findings, const Decision& decision);
/// One plot, one table and one command, in a page that refers to nothing outside of itself. `about`
/// says when, where and how it was measured.
std::string to_html(const TuneFindings& findings, const Decision& decision,
                    const std::string& about);

}  // namespace plait::tune
