// plait/detail/gather_grid.h: the slots of a sweep as the source from which gather() fills the
// grid of an edge (plait/detail/edge_grid.h). Programs use plait/visit_vertices.h, which calls it.
#pragma once

#include <cstddef>

#include "plait/detail/edge_grid.h"
#include "plait/detail/namespace.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/sweep.h"

PLAIT_BEGIN_NAMESPACE

/// The source of the records: an access of a sweep with Reach::kFaces or more. Levels count
/// refinements of the base mesh.
template <class Record>
struct SlotSource {
  const SweepView& view;
  std::size_t access;
  int base_level;
  SlotRecords<const Record> slot(int level, EdgeId edge) const {
    return view.slot(access, level_number(BaseRelativeLevel(level), base_level), edge)
        .template of<const Record>();
  }
};

PLAIT_END_NAMESPACE
