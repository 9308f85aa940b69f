#include "compressed/filters/filter.h"

#include <fmt/format.h>

#include "plait/error.h"

namespace plait {

bool is_filter(std::string_view stage) { return stage == "shuffle"; }

FilterChain make_filter_chain(std::string_view specification, std::size_t component_bytes) {
  FilterChain chain;
  if (specification == "none") return chain;
  if (specification != "shuffle")
    throw Error(ErrorCode::kNotSupported, fmt::format("choose filter \"{}\": expected one of none, "
                                                      "shuffle",
                                                      specification));
  if (component_bytes != 1 && component_bytes != 2 && component_bytes != 4 && component_bytes != 8)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("choose filter \"shuffle\": expected components of 1, 2, 4 or 8 bytes, "
                            "found {}",
                            component_bytes));
  if (component_bytes > 1) chain.push_back(make_shuffle_filter(component_bytes));
  return chain;
}

}  // namespace plait
