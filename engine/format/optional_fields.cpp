#include "format/optional_fields.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <utility>

#include "format/manifest.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The size of an empty text with an empty name.
constexpr std::size_t kLeastTextBytes = 8;

bool is_rounding(const Rounding& rounding) {
  const auto is_length = [](double number) { return number >= 0 && std::isfinite(number); };
  return is_length(rounding.bound) && is_length(rounding.step) &&
         is_length(rounding.largest_error) && is_length(rounding.rms_error);
}

void encode_roundings(const VersionDescription& version, FieldWriter& fields) {
  const auto is_rounded = [](const AttributeRecord& attribute) {
    return attribute.rounding.has_value();
  };
  fields.put(static_cast<std::uint32_t>(std::ranges::count_if(version.attributes, is_rounded)));
  for (const AttributeRecord& attribute : version.attributes) {
    if (!is_rounded(attribute)) continue;
    fields.put(attribute.number);
    fields.put(static_cast<std::uint8_t>(attribute.rounding->metric));
    for (const double length : {attribute.rounding->bound, attribute.rounding->step,
                                attribute.rounding->largest_error, attribute.rounding->rms_error})
      fields.put(std::bit_cast<std::uint64_t>(length));
  }
}

void take_roundings(FieldReader& fields, VersionDescription& version) {
  const auto count = fields.take<std::uint32_t>("the number of rounded attributes");
  fields.require(count <= version.attributes.size(), "the number of rounded attributes", count);
  for (std::uint32_t at = 0; at < count; ++at) {
    const auto number = fields.take<std::uint32_t>("the number of a rounded attribute");
    const auto attribute = std::ranges::find(version.attributes, number, &AttributeRecord::number);
    fields.require(attribute != version.attributes.end() && !attribute->rounding,
                   "the number of a rounded attribute", number);
    Rounding rounding;
    const auto metric = fields.take<std::uint8_t>("the metric of a rounding");
    rounding.metric = static_cast<ErrorMetric>(metric);
    fields.require(
        rounding.metric == ErrorMetric::kComponent || rounding.metric == ErrorMetric::kEuclidean,
        "the metric of a rounding", metric);
    for (double* const length :
         {&rounding.bound, &rounding.step, &rounding.largest_error, &rounding.rms_error})
      *length = std::bit_cast<double>(fields.take<std::uint64_t>("a length of a rounding"));
    fields.require(is_rounding(rounding), "a length of a rounding", "no length");
    attribute->rounding = rounding;
  }
}

void encode_texts(const VersionDescription& version, FieldWriter& fields) {
  fields.put(static_cast<std::uint32_t>(version.texts.size()));
  for (const auto& [name, text] : version.texts) {
    fields.put_text(name, kMaxAttributeNameBytes, "a text's name");
    fields.put_utf8(text, kMaxTextBytes, "a text");
  }
}

void take_texts(FieldReader& fields, VersionDescription& version) {
  const auto count = fields.take<std::uint32_t>("the number of texts");
  fields.require(count <= fields.bytes_left() / kLeastTextBytes, "the number of texts", count);
  for (std::uint32_t at = 0; at < count; ++at) {
    std::string name = fields.take_text(kMaxAttributeNameBytes, "a text's name");
    fields.require(is_attribute_name(name), "a text's name", name);
    const bool ascends = version.texts.empty() || version.texts.rbegin()->first < name;
    fields.require(ascends, "a text's name, which must ascend", name);
    version.texts.emplace(std::move(name), fields.take_utf8(kMaxTextBytes, "a text"));
  }
}

void encode_face_attributes(const VersionDescription& version, FieldWriter& fields) {
  fields.put(static_cast<std::uint32_t>(version.face_attributes.size()));
  for (const FaceAttributeRecord& attribute : version.face_attributes) {
    fields.put_text(attribute.schema.name, kMaxAttributeNameBytes, "a face attribute's name");
    fields.put(attribute.number);
    fields.put(static_cast<std::uint8_t>(attribute.schema.type));
    fields.put(attribute.checksum);
  }
}

void take_face_attributes(FieldReader& fields, VersionDescription& version) {
  const auto count = fields.take<std::uint32_t>("the number of face attributes");
  fields.require(count <= kMaxFaceAttributes, "the number of face attributes", count);
  for (std::uint32_t at = 0; at < count; ++at) {
    FaceAttributeRecord attribute;
    std::string& name = attribute.schema.name;
    name = fields.take_text(kMaxAttributeNameBytes, "a face attribute's name");
    fields.require(is_attribute_name(name), "a face attribute's name", name);
    attribute.number = fields.take<std::uint32_t>("a face attribute's number");
    const auto differs = [&](const auto& other) { return other.number != attribute.number; };
    fields.require(attribute.number < version.next_attribute_number &&
                       std::ranges::all_of(version.attributes, differs) &&
                       std::ranges::all_of(version.face_attributes, differs),
                   "a face attribute's number", attribute.number);
    fields.require(
        std::ranges::none_of(version.face_attributes,
                             [&](const auto& other) { return other.schema.name == name; }),
        "a repeated face attribute name", name);
    const auto type = fields.take<std::uint8_t>("a face attribute's type");
    attribute.schema.type = static_cast<ComponentType>(type);
    attribute.schema.components = 1;
    fields.require(component_bytes(attribute.schema.type) > 0, "a face attribute's type", type);
    attribute.checksum = fields.take<std::uint64_t>("a checksum of face records");
    version.face_attributes.push_back(std::move(attribute));
  }
}

}  // namespace

std::uint32_t optional_features_of(const VersionDescription& version) {
  const bool rounded = std::ranges::any_of(
      version.attributes, [](const auto& attribute) { return attribute.rounding.has_value(); });
  return (rounded ? kRoundingsFeature : 0) | (version.texts.empty() ? 0 : kTextsFeature) |
         (version.face_attributes.empty() ? 0 : kFacesFeature);
}

void encode_optional_fields(const VersionDescription& version, FieldWriter& fields) {
  const std::uint32_t features = optional_features_of(version);
  if ((features & kRoundingsFeature) != 0) encode_roundings(version, fields);
  if ((features & kTextsFeature) != 0) encode_texts(version, fields);
  if ((features & kFacesFeature) != 0) encode_face_attributes(version, fields);
}

void take_optional_fields(FieldReader& fields, VersionDescription& version,
                          std::uint32_t optional_features) {
  if ((optional_features & kRoundingsFeature) != 0) take_roundings(fields, version);
  if ((optional_features & kTextsFeature) != 0) take_texts(fields, version);
  if ((optional_features & kFacesFeature) != 0) take_face_attributes(fields, version);
}

PLAIT_END_NAMESPACE
