// The figures of a plan of a subdivision.
#pragma once

#include <filesystem>
#include <vector>

#include "parts/cuts.h"
#include "parts/plan_file.h"
#include "plait/base_mesh.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// By the levels and attributes of the plan.
PartCost cost_of_subdivision(const PlanFile& file);
/// Enters the parts that begin with these edges, and the number of files. `mesh` is that of the
/// plan, and `edges` are its.
void add_figures(PlanFile& file, const BaseMesh& mesh, const EdgesInOrder& edges,
                 const std::vector<EdgeId>& starts);

/// What the part with most bytes needs. `plan_directory` has the files of the plan but `plan`;
/// `final_path` is its path, beside which a directory is made for a moment.
PartMemory memory_of_parts(const Directory& plan_directory, const PlanFile& file,
                           const std::filesystem::path& final_path,
                           const BackendRegistry& backends);

PLAIT_END_NAMESPACE
