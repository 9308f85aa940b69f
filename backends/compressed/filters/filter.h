// backends/compressed/filters/filter.h: reversible transforms of one block that keep its size and
// make it easier to compress.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace plait {

/// Stateless: safe from any number of threads. The two spans have one size and do not overlap.
/// decode() inverts encode() and accepts any bytes.
class Filter {
 public:
  virtual ~Filter() = default;
  virtual void encode(std::span<const std::byte> raw, std::span<std::byte> filtered) const = 0;
  virtual void decode(std::span<const std::byte> filtered, std::span<std::byte> raw) const = 0;
};

/// Encoded front to back, decoded back to front; "none" is the empty chain.
using FilterChain = std::vector<std::unique_ptr<Filter>>;

/// Whether a stage of a pipeline is the name of a filter.
bool is_filter(std::string_view stage);

/// "none" or "shuffle". Errors: kNotSupported naming the filters there are; kInvalidArgument if
/// `component_bytes` is not 1, 2, 4 or 8.
FilterChain make_filter_chain(std::string_view specification, std::size_t component_bytes);

/// Gathers first bytes of all components, then second bytes, and so on; the bytes after the last
/// whole component stay where they are. `component_bytes` is 2, 4 or 8.
std::unique_ptr<Filter> make_shuffle_filter(std::size_t component_bytes);

}  // namespace plait
