#include "mesh/files/ply_records.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "base/number_type.h"
#include "io/huge_pages.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

PlyRecords::PlyRecords(const PlyElement& element, std::vector<PlyAttribute> attributes)
    : element_(&element),
      attributes_(std::move(attributes)),
      records_(attributes_.size()),
      numbers_(element.properties.size()),
      lost_digits_(element.properties.size()) {
  std::vector<std::size_t> offsets;
  std::size_t offset = 0;
  for (const PlyProperty& property : element.properties) {
    offsets.push_back(offset);
    offset += property.is_list
                  ? component_bytes(property.count_type) + 3 * component_bytes(property.type)
                  : component_bytes(property.type);
  }
  for (std::size_t at = 0; at < attributes_.size(); ++at)
    for (const std::size_t property : attributes_[at].properties)
      parts_.push_back({offsets[property], component_bytes(element.properties[property].type), at});
}

void PlyRecords::reserve(std::uint64_t count) {
  for (std::size_t at = 0; at < attributes_.size(); ++at)
    reserve_huge(records_[at], count * attributes_[at].schema.record_bytes());
}

/// Returns false if the type has no such number.
bool PlyRecords::append_number(std::size_t attribute, std::size_t property) {
  const double value = numbers_[property];
  std::vector<std::byte>& to = records_[attribute];
  return with_number_type(element_->properties[property].type, [&]<class Number>(Number number) {
    const bool fits = value >= static_cast<double>(std::numeric_limits<Number>::lowest()) &&
                      value <= static_cast<double>(std::numeric_limits<Number>::max());
    if (std::is_integral_v<Number> ? !fits || value != std::floor(value)
                                   : !fits && std::isfinite(value))
      return false;
    number = static_cast<Number>(value);
    const auto bytes = std::as_bytes(std::span(&number, 1));
    to.insert(to.end(), bytes.begin(), bytes.end());
    return true;
  });
}

void PlyRecords::say_lost_digits(const Input& input, Reading& reading) const {
  for (std::size_t property = 0; property < lost_digits_.size(); ++property)
    if (lost_digits_[property].count() > 0)
      reading.warn(fmt::format("{}: {} property {}: {}", input.path().native(), element_->name,
                               in_quotes(element_->properties[property].name),
                               lost_digits_[property].text()));
}

std::vector<MeshAttribute> PlyRecords::finish() {
  std::vector<MeshAttribute> result;
  for (std::size_t at = 0; at < attributes_.size(); ++at)
    result.push_back({attributes_[at].schema, std::move(records_[at])});
  return result;
}

PLAIT_END_NAMESPACE
