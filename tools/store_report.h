// tools/store_report.h: the properties of a store as one JSON object.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "plait/extend/backend_registry.h"
#include "plait/extend/check_store.h"
#include "plait/store.h"

namespace plait {

/// `backends` choose what "auto" would be for the store now. Reads tables, and no vertices.
nlohmann::ordered_json store_report(Store& store, const BackendRegistry& backends);
/// What can be said of a store that cannot be opened; `why` it cannot.
nlohmann::ordered_json closed_store_report(const StoreDescription& store,
                                           const std::filesystem::path& path,
                                           const std::string& why);

}  // namespace plait
