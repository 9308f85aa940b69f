// backends/compressed/filters/filter.h: reversible transforms of one block. They keep its size and
// make it compress better.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace plait {

/// A filter has no state, so any number of threads may use it. The two spans have the same size and
/// do not overlap. decode() is the inverse of encode() and accepts any bytes.
class Filter {
 public:
  virtual ~Filter() = default;
  virtual void encode(std::span<const std::byte> raw, std::span<std::byte> filtered) const = 0;
  virtual void decode(std::span<const std::byte> filtered, std::span<std::byte> raw) const = 0;
};

/// Encoding applies the filters from first to last, decoding from last to first. "none" is the
/// empty chain.
using FilterChain = std::vector<std::unique_ptr<Filter>>;

/// "none" or "shuffle". Errors: kNotSupported (the message lists the known filters);
/// kInvalidArgument if `component_bytes` is not 1, 2, 4 or 8.
FilterChain make_filter_chain(std::string_view specification, std::size_t component_bytes);

/// Writes the first bytes of all components, then all second bytes, and so on. Bytes after the last
/// whole component keep their place. `component_bytes` is 2, 4 or 8.
std::unique_ptr<Filter> make_shuffle_filter(std::size_t component_bytes);

}  // namespace plait
