// export/vector_text.h: writes an attribute of three numbers as lines of text.
#pragma once

#include "export/format_writers.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// One line for each vertex: `before`, and the shortest decimals that give the same numbers when
/// they are read. Calls task.progress with the vertices so far if `counts`, else with all vertices.
void write_vector_lines(const ExportTask& task, OutputStream& output, AttributeId attribute,
                        std::string_view before, bool counts);

PLAIT_END_NAMESPACE
