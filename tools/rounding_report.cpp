#include "rounding_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace plait {

std::string to_text(const Rounding& rounding) {
  return fmt::format(
      "rounded to steps of {:.6g}: error at most {:.6g} ({}), largest found {:.6g}, root mean "
      "square {:.6g}",
      rounding.step, rounding.bound, to_string(rounding.metric), rounding.largest_error,
      rounding.rms_error);
}

nlohmann::ordered_json to_json(const Rounding& rounding) {
  return {{"metric", to_string(rounding.metric)},
          {"bound", rounding.bound},
          {"step", rounding.step},
          {"largest_error", rounding.largest_error},
          {"rms_error", rounding.rms_error}};
}

}  // namespace plait
