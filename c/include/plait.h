/* plait.h: the C interface of plait, a storage engine for semi-regular triangle meshes. C11 and
 * C++. docs/c_api.md explains it; docs/glossary.md has the words.
 *
 * Errors: a call returns PLAIT_OK or the code of an error. plait_error_message() then has the
 * reason. A failed call changes no output argument. No C++ exception leaves a call.
 *
 * Arguments: a pointer must not be NULL unless its comment allows it. A call with NULL fails with
 * PLAIT_ERROR_INVALID_ARGUMENT. Texts are UTF-8 and end with a zero byte. The library copies the
 * texts and arrays that it needs after the call. Options may be NULL: then all have their defaults.
 * A program makes options by the macro PLAIT_..._INIT, which sets struct_size and the defaults.
 *
 * Lifetimes: the program ends each handle once: a store by plait_store_close() or
 * plait_store_release(), a reader by plait_reader_close(), a view by plait_view_release(), a patch
 * writer by plait_patch_writer_close(), a served store by plait_served_close(). These calls accept
 * NULL. A pointer that a call returns is valid until the handle ends, unless its comment says
 * otherwise.
 *
 * Threads: any number of threads may call one reader or one view at the same time. While a thread
 * is in a call with a `plait_store*` that is not const, no other thread may use the store or its
 * readers. Different stores are independent. A call that changes a store fails with
 * PLAIT_ERROR_BUSY while the store has readers or views.
 *
 * Callbacks run in the thread that made the call. They must return: they must not throw or longjmp.
 * A callback may read the store of its call. Calls that change, commit or close this store fail
 * with PLAIT_ERROR_BAD_STATE there, and a callback must not release it.
 *
 * Processes: in a process that was forked from the one that has a store open, every call for the
 * store, its readers and its views fails with PLAIT_ERROR_BAD_STATE (docs/threads.md). */
#ifndef PLAIT_H
#define PLAIT_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define PLAIT_API __attribute__((visibility("default")))
#else
#define PLAIT_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Errors and versions ---- */

/* A later version may add codes. Numbers never change. */
typedef int32_t plait_status;
enum {
  PLAIT_OK = 0,
  PLAIT_ERROR_NOT_FOUND = 1,        /* a file, store, attribute or level does not exist */
  PLAIT_ERROR_INVALID_ARGUMENT = 2, /* an argument out of its range, or a refused input file */
  PLAIT_ERROR_CORRUPTION = 3,       /* stored bytes are damaged */
  PLAIT_ERROR_NOT_SUPPORTED = 4,    /* this build or machine lacks a backend, codec or feature */
  PLAIT_ERROR_IO = 5,               /* the operating system refused a file operation */
  PLAIT_ERROR_NO_SPACE = 6,         /* the disk or the quota is full */
  PLAIT_ERROR_OUT_OF_MEMORY = 7,    /* an allocation failed */
  PLAIT_ERROR_BUDGET = 8,           /* the memory budget is too small */
  PLAIT_ERROR_BUSY = 9,             /* somebody else has the store open; or it has readers */
  PLAIT_ERROR_BAD_STATE = 10,       /* a call that the object's state forbids */
  PLAIT_ERROR_CANCELLED = 11,       /* a callback cancelled the work */
  PLAIT_ERROR_INTERNAL = 12         /* a mistake in the library */
};

/* The reason of the last call in this thread that failed. Valid until another call fails in this
 * thread. Never NULL; empty if no call has failed. */
PLAIT_API const char* plait_error_message(void);
/* The file or directory that this error is about; empty if it is about none, or if no call has
 * failed. Valid as the message. */
PLAIT_API const char* plait_error_path(void);
/* The byte of this file that the error is about, or PLAIT_NO_OFFSET. */
#define PLAIT_NO_OFFSET UINT64_MAX
PLAIT_API uint64_t plait_error_offset(void);
/* "ok", "not_found", ...; "unknown" for a number that is no code. Valid for ever. */
PLAIT_API const char* plait_status_name(plait_status status);

/* The interface that this header declares. It grows when a function or a member is added. A program
 * can use a library whose plait_abi_version() is at least its own PLAIT_ABI_VERSION. */
#define PLAIT_ABI_VERSION 1u
PLAIT_API uint32_t plait_abi_version(void);
/* The version of the library, such as "0.1.0". */
PLAIT_API const char* plait_version_string(void);
/* What is built in. One line for each of: version, backends, codecs, filters, schemes, executors,
 * layouts. A line is a word, a colon, and names with blanks between them. */
PLAIT_API const char* plait_build_info(void);

/* Loads a plug-in: a shared library that adds backends, codecs and filters (plait/extend/plugin.h,
 * docs/plugins.md). Stores that this process makes or opens later can use them. A plug-in stays
 * loaded until the process ends, and runs as a part of it, so load only files that you trust. The
 * call does nothing for a plug-in that was loaded before. After an error, nothing was added. */
PLAIT_API plait_status plait_plugin_load(const char* file);

/* ---- Handles and types ---- */

typedef struct plait_store plait_store;   /* a store that this process has opened */
typedef struct plait_reader plait_reader; /* reads patches and vertices of a store */
typedef struct plait_view plait_view;     /* the records of one patch, pinned in memory */
typedef struct plait_patch_writer plait_patch_writer; /* fills levels patch by patch */

typedef int32_t plait_component_type;
enum {
  PLAIT_FLOAT32 = 1,
  PLAIT_FLOAT64 = 2,
  PLAIT_INT8 = 3,
  PLAIT_INT16 = 4,
  PLAIT_INT32 = 5,
  PLAIT_INT64 = 6,
  PLAIT_UINT8 = 7,
  PLAIT_UINT16 = 8,
  PLAIT_UINT32 = 9,
  PLAIT_UINT64 = 10
};

/* Called many times during long work. `phase` is a short text, valid during the call. Returns 0 to
 * cancel the work: the call then fails with PLAIT_ERROR_CANCELLED. */
typedef int (*plait_progress)(const char* phase, uint64_t done, uint64_t total, void* user);
/* Told what the library changed in an input. `text` is valid during the call. */
typedef void (*plait_warning)(const char* text, void* user);

/* ---- Stores ---- */

enum {
  PLAIT_DURABILITY_COMMIT = 0, /* a commit returns when the version is on the disk */
  PLAIT_DURABILITY_NONE = 1    /* for temporary stores: never waits for the disk */
};
#define PLAIT_NO_POSITIONS 0 /* position_type: the program adds "position" itself */
/* position_type: PLAIT_FLOAT32, or PLAIT_FLOAT64 if float32 would move a vertex by more than a
 * thousandth of the shortest edge there, or is too coarse for three levels below base_level; `warn`
 * is told. */
#define PLAIT_AUTOMATIC_POSITIONS (-1)
#define PLAIT_AUTOMATIC_THREADS (-1) /* io_threads: the library chooses */
#define PLAIT_DEFAULT_BUDGET_BYTES (UINT64_C(256) << 20)

typedef int32_t plait_event_kind;
enum {
  PLAIT_EVENT_OPENED = 0,    /* a store was made or opened */
  PLAIT_EVENT_COMMITTED = 1, /* a commit has made a version */
  PLAIT_EVENT_EVICTED = 2,   /* a block left memory, because others needed its room */
  PLAIT_EVENT_SLOW_READ = 3  /* a block was read, and that took long */
};
/* What a store tells a program's log or metrics. Texts are valid during the call. */
typedef struct plait_event {
  size_t struct_size;
  const char* store;     /* its path; empty for a store in memory */
  const char* attribute; /* evicted, slow read: its name when the store was opened */
  uint64_t version;      /* opened, committed: commits so far */
  uint64_t duration_ns;  /* all but evicted */
  uint64_t block, bytes; /* evicted, slow read; before compression */
  plait_event_kind kind;
  int32_t level; /* evicted, slow read */
} plait_event;
/* Calls come from any thread that uses the store and from its I/O threads, several at the same
 * time. A call should return soon, because a read waits for it. It may take
 * plait_store_get_statistics(), and call no other function of the store. */
typedef void (*plait_event_callback)(const plait_event* event, void* user);

/* A parallel loop of the program's thread pool: it calls body(0, loop) to body(count - 1, loop),
 * each once, in any order and on any number of threads, one included, and returns when all have
 * returned. A body may wait for another one that has begun: each has a thread to itself until it
 * returns. */
typedef void (*plait_parallel_body)(int32_t number, void* loop);
typedef void (*plait_parallel_for)(int32_t count, plait_parallel_body body, void* loop, void* user);

/* Options of plait_store_create(). */
typedef struct plait_store_options {
  size_t struct_size;
  const char* backend;     /* a name, or "auto", which NULL also means: see expected_bytes */
  const char* pipeline;    /* such as "shuffle,zstd:1"; NULL: the default of the backend */
  const char* layout;      /* the order of the faces; NULL: "auto" */
  const char* base_scheme; /* the scheme that refines the mesh to base_level; NULL: "loop" */
  /* Unit of I/O: 4 KiB to 1 GiB, a power of two; 0: 64 KiB, or 256 KiB if the backend compresses.
   * plait_store_info has the size that the store has. */
  uint64_t block_bytes;
  uint64_t budget_bytes; /* the most memory for blocks; at least 64 KiB */
  /* For backend "auto": the bytes that all levels will have, before compression; 0: few, or not
   * known. A store without a path gets "memory", one with a pipeline "compressed", one that is
   * large compared with the memory "uring" where it can run; others get "pread". */
  uint64_t expected_bytes;
  plait_warning warn; /* NULL: changes of the mesh are not reported */
  void* user;         /* for `warn` */
  int32_t base_level; /* so often the mesh is refined in memory, to make slots smaller */
  int32_t io_threads; /* 0 to 64, or PLAIT_AUTOMATIC_THREADS */
  plait_component_type position_type; /* PLAIT_FLOAT32, PLAIT_FLOAT64 or PLAIT_..._POSITIONS */
  int32_t durability;                 /* PLAIT_DURABILITY_... */
  plait_event_callback event;         /* NULL: the store tells nothing */
  void* event_user;                   /* for `event` */
  uint64_t slow_read_ns;              /* a read that takes longer is slow; 0: 100 ms */
  /* NULL: work on the store with `threads` above 1 starts threads. Otherwise it calls this with
   * count = `threads`, and any of the program's threads calls `progress`, one at a time. */
  plait_parallel_for parallel_for;
  void* parallel_user; /* for `parallel_for` */
} plait_store_options;
#define PLAIT_STORE_OPTIONS_INIT                                                                 \
  {                                                                                              \
    sizeof(plait_store_options), NULL, NULL, NULL, NULL, 0, PLAIT_DEFAULT_BUDGET_BYTES, 0, NULL, \
        NULL, 0, PLAIT_AUTOMATIC_THREADS, PLAIT_FLOAT32, PLAIT_DURABILITY_COMMIT, NULL, NULL, 0, \
        NULL, NULL                                                                               \
  }

/* Options of plait_store_open(). */
typedef struct plait_open_options {
  size_t struct_size;
  uint64_t budget_bytes;
  int32_t writable; /* 1: for writing; 0: for reading */
  int32_t io_threads;
  int32_t durability;
  int32_t reserved; /* 0 */
  plait_event_callback event;
  void* event_user;
  uint64_t slow_read_ns;
  plait_parallel_for parallel_for;
  void* parallel_user;
} plait_open_options;
#define PLAIT_OPEN_OPTIONS_INIT                                                         \
  {                                                                                     \
    sizeof(plait_open_options), PLAIT_DEFAULT_BUDGET_BYTES, 0, PLAIT_AUTOMATIC_THREADS, \
        PLAIT_DURABILITY_COMMIT, 0, NULL, NULL, 0, NULL, NULL                           \
  }

/* Makes a store of triangles, with attribute "position" at the base level. `positions` has three
 * numbers for each vertex. `triangles` has three vertices for each triangle, counterclockwise. The
 * mesh must be an oriented 2-manifold, with or without border. The store drops vertices that no
 * triangle uses, turns triangles to one orientation, and puts them in the order of the layout:
 * plait_store_get_faces() has the result, and plait_store_get_input_maps() tells where everything
 * was. `path` is a directory that does not exist; with an empty one, the store is only in
 * memory, with a backend that writes no files. The first commit makes the store permanent. Errors:
 * INVALID_ARGUMENT also names the first bad vertex or triangle; NOT_SUPPORTED, IO, NO_SPACE. */
PLAIT_API plait_status plait_store_create(const char* path, const double* positions,
                                          uint64_t vertex_count, const uint32_t* triangles,
                                          uint64_t triangle_count,
                                          const plait_store_options* options, plait_store** store);
/* The same for the triangles of a file: PLY, OBJ or OFF, also .gz and .zst. */
PLAIT_API plait_status plait_store_create_from_file(const char* path, const char* mesh_path,
                                                    const plait_store_options* options,
                                                    plait_store** store);
/* Opens the last committed version. Errors: NOT_FOUND, CORRUPTION, NOT_SUPPORTED; BUSY if another
 * writer has the store open. */
PLAIT_API plait_status plait_store_open(const char* path, const plait_open_options* options,
                                        plait_store** store);
/* Sets *has_commit to 0 if the directory is empty, or if its writer was killed before the first
 * commit; otherwise to 1. */
PLAIT_API plait_status plait_store_has_commit(const char* path, int32_t* has_commit);
/* Publishes all levels and attributes as the next version, if anything has changed. Errors:
 * BAD_STATE, for example while a level or base records are unfinished because work on them was
 * cancelled; IO, NO_SPACE. */
PLAIT_API plait_status plait_store_commit(plait_store* store);
/* Brings the store back to its last commit, or, before the first one, to a store without
 * attributes: discards all changes, and what cancelled and failed work left. Errors: BAD_STATE
 * after a failed commit; BUSY; those of plait_store_open(). */
PLAIT_API plait_status plait_store_roll_back(plait_store* store);
/* Ends the handle. Changes since the last commit are lost. Errors: BUSY with the number of readers
 * and views; then the handle stays valid. Does nothing for NULL. */
PLAIT_API plait_status plait_store_close(plait_store* store);
/* Ends the handle at once. Its readers and views stay valid, and keep the files and locks of the
 * store until the last of them ends. Does nothing for NULL. */
PLAIT_API void plait_store_release(plait_store* store);

/* ---- What a store contains ---- */

/* What a store contains, and where it is. */
typedef struct plait_store_info {
  size_t struct_size;
  /* Texts are valid until the next call that changes the store. */
  const char* path;
  const char* backend;
  const char* pipeline;
  const char* layout;
  const char* scheme;  /* that made the levels; empty: none, or not known */
  const char* program; /* the version of plait that made the levels; may be empty */
  uint64_t sequence;   /* commits so far */
  uint64_t stored_bytes;
  uint64_t block_bytes;
  uint64_t budget_bytes;
  uint64_t vertex_count; /* of the base mesh, as the next three */
  uint64_t edge_count;
  uint64_t face_count; /* patches of the store */
  uint64_t border_edge_count;
  uint8_t uuid[16];
  uint32_t attribute_count;
  int32_t base_level;
  int32_t finest_level; /* of the attribute with the most levels */
  int32_t writable;
  int32_t limit;                  /* 1: positions were projected to the limit surface */
  plait_component_type precision; /* of the arithmetic that made the levels */
  /* What this machine did not give the store when it was opened, one line each: a backend that the
   * kernel refuses, so that another one reads its files; locks that the file system does not have.
   * Empty: nothing. */
  const char* notices;
} plait_store_info;
#define PLAIT_STORE_INFO_INIT                                                                     \
  {                                                                                               \
    sizeof(plait_store_info), NULL, NULL, NULL, NULL, NULL, NULL, 0, 0, 0, 0, 0, 0, 0, 0, {0}, 0, \
        0, 0, 0, 0, 0, NULL                                                                       \
  }
PLAIT_API plait_status plait_store_get_info(const plait_store* store, plait_store_info* info);

/* An attribute of a store. */
typedef struct plait_attribute_info {
  size_t struct_size;
  const char* name; /* valid until the next call that changes the store */
  uint64_t record_bytes;
  plait_component_type type;
  uint32_t components;  /* numbers in a record */
  int32_t finest_level; /* the attribute has the base level and all levels up to this one */
  uint32_t index;
} plait_attribute_info;
#define PLAIT_ATTRIBUTE_INFO_INIT \
  { sizeof(plait_attribute_info), NULL, 0, 0, 0, 0, 0 }
/* Errors: NOT_FOUND unless `index` is below attribute_count. */
PLAIT_API plait_status plait_store_get_attribute(const plait_store* store, uint32_t index,
                                                 plait_attribute_info* info);
/* Errors: NOT_FOUND; the message lists the attributes of the store. */
PLAIT_API plait_status plait_store_find_attribute(const plait_store* store, const char* name,
                                                  plait_attribute_info* info);

/* Vertices, edges and faces of the whole mesh at a level, base level or finer. An output may be
 * NULL. */
PLAIT_API plait_status plait_store_get_counts(const plait_store* store, int32_t level,
                                              uint64_t* vertices, uint64_t* edges, uint64_t* faces);
/* The finest level of each base face: that of the store, unless its faces have depths of their own.
 * Vertices, edges and faces are then counted as they are drawn (docs/adaptive.md). `count` is that
 * of plait_store_get_faces(). Errors: INVALID_ARGUMENT for another count. */
PLAIT_API plait_status plait_store_get_depths(const plait_store* store, int32_t* depths,
                                              uint64_t count);
/* The triangles of the whole mesh at a level, three vertices for each, counterclockwise; of a face
 * with fewer levels those of its own depth, with the vertices of deeper neighbours on its sides, so
 * that no gap is left. Vertices are numbered as plait_reader_read_vertices() does level by level:
 * those of the base level, then those of each finer level. Triangles are in the order of the faces.
 * `capacity` is the room of `triangles` in triangles: plait_store_get_counts() says how many there
 * are. Errors: INVALID_ARGUMENT for a level, for too little room and for 2^32 vertices or more;
 * OUT_OF_MEMORY. */
PLAIT_API plait_status plait_store_get_triangles(const plait_store* store, int32_t level,
                                                 uint32_t* triangles, uint64_t capacity,
                                                 uint64_t* count);
/* The corners of the base faces, three vertices for each face. Face f is patch f. Valid until the
 * store ends. */
PLAIT_API plait_status plait_store_get_faces(const plait_store* store, const uint32_t** triangles,
                                             uint64_t* face_count);
/* The positions from which the store was made, three numbers for each base vertex. */
PLAIT_API plait_status plait_store_get_base_positions(const plait_store* store,
                                                      const double** positions,
                                                      uint64_t* vertex_count);

/* What the pager of a store or of a reader did. */
typedef struct plait_paging_statistics {
  size_t struct_size;
  uint64_t blocks_read, bytes_read; /* before compression */
  uint64_t blocks_written, bytes_written;
  uint64_t blocks_prefetched, blocks_evicted;
  uint64_t read_waits, read_wait_ns; /* callers that waited for a block */
  uint64_t write_waits, write_wait_ns;
  uint64_t peak_frame_bytes; /* the most memory of blocks at one moment */
} plait_paging_statistics;
#define PLAIT_PAGING_STATISTICS_INIT \
  { sizeof(plait_paging_statistics), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0 }
PLAIT_API plait_status plait_store_get_statistics(const plait_store* store,
                                                  plait_paging_statistics* statistics);

/* ---- The program's own mesh ---- */

/* Where the vertices and triangles of the base mesh are in the mesh from which the store was made
 * (the input), and the other way round. So a program's own arrays and materials still fit. Each
 * array has the number of entries that its comment names; UINT32_MAX stands for nothing. */
typedef struct plait_input_maps {
  size_t struct_size;
  const uint32_t*
      input_vertices; /* vertex_count: its number in the input; nothing: made by base_level */
  const uint32_t* input_faces; /* face_count: the input's face that it is or is a part of */
  const uint8_t* turned;       /* face_count: 1: second and third corner of it were exchanged */
  const uint32_t* vertices;    /* input_vertex_count: the vertex; nothing: it was dropped */
  const uint32_t* faces;       /* input_face_count: the face, or the first of its parts */
  uint64_t vertex_count, face_count, input_vertex_count, input_face_count;
} plait_input_maps;
#define PLAIT_INPUT_MAPS_INIT \
  { sizeof(plait_input_maps), NULL, NULL, NULL, NULL, NULL, 0, 0, 0, 0 }
/* Valid until the store ends. Errors: OUT_OF_MEMORY. */
PLAIT_API plait_status plait_store_get_input_maps(const plait_store* store, plait_input_maps* maps);

/* A point of the triangular grid of a base face. The corners are (0, 0), (size, 0) and (0, size),
 * in the order of plait_store_get_faces(). */
typedef struct plait_point {
  uint32_t face;
  int32_t i, j, size;
} plait_point;
/* Where the vertices `first` to `first` + `count` - 1 of those that `level` creates are, to sample
 * height maps and textures: they are numbered as in plait_reader_read_vertices(). A vertex on an
 * edge is in two faces, and a base vertex in many: this is a point of one of them. `level` may be
 * any level from the base level on. */
PLAIT_API plait_status plait_store_get_points(const plait_store* store, int32_t level,
                                              uint64_t first, uint64_t count, plait_point* points);

/* ---- Texts and attributes of base faces ---- */

/* What people note about a store: units, coordinate system, author. Commits record them, and copies
 * have them. `name` has 1 to 255 characters of [A-Za-z0-9_-]. `text` has at most 64 KiB, without
 * control characters but tab and line feed; an empty one or NULL removes the text. */
PLAIT_API plait_status plait_store_set_text(plait_store* store, const char* name, const char* text);
/* Valid until the next call that changes the store. Errors: NOT_FOUND. */
PLAIT_API plait_status plait_store_get_text(const plait_store* store, const char* name,
                                            const char** text);
/* The names, in ascending order. Errors: NOT_FOUND if the store has no more than `index` texts.
 * Valid as the text. */
PLAIT_API plait_status plait_store_get_text_name(const plait_store* store, uint32_t index,
                                                 const char** name);

/* Attributes of the faces of the base mesh (material, part number): one number for each face,
 * zero at first. Their names are apart from those of other attributes. Commits record them; copies
 * and exports have them. */
PLAIT_API plait_status plait_store_add_face_attribute(plait_store* store, const char* name,
                                                      plait_component_type type);
/* Errors: NOT_FOUND. */
PLAIT_API plait_status plait_store_remove_face_attribute(plait_store* store, const char* name);
/* Fills name, record_bytes, type, components (1) and index. Errors: NOT_FOUND if the store has no
 * more than `index` face attributes. */
PLAIT_API plait_status plait_store_get_face_attribute(const plait_store* store, uint32_t index,
                                                      plait_attribute_info* info);
/* The numbers, for reading. Valid until the next call that changes the attributes of the store. An
 * output may be NULL, here and in the next call. */
PLAIT_API plait_status plait_store_get_face_records(const plait_store* store, const char* name,
                                                    const void** records, uint64_t* count);
/* The same, for writing. The program writes before it opens a reader. */
PLAIT_API plait_status plait_store_edit_face_records(plait_store* store, const char* name,
                                                     void** records, uint64_t* count);

/* ---- Attributes ---- */

/* Adds an attribute whose levels go up to `finest_level`. All records are zero. `name` has 1 to 255
 * characters of [A-Za-z0-9_-], `components` is 1 to 255. */
PLAIT_API plait_status plait_store_add_attribute(plait_store* store, const char* name,
                                                 plait_component_type type, uint32_t components,
                                                 int32_t finest_level);
/* Adds the next finer level to an attribute. Its records are zero. */
PLAIT_API plait_status plait_store_add_level(plait_store* store, const char* name);
/* Sets the pipeline of levels that later calls add to the attribute. Ranges of levels may have
 * others: "shuffle,zstd:1;@1-3=lz4;@6-=none". If blocks are encoded from others, the next commit
 * encodes them. */
PLAIT_API plait_status plait_store_set_pipeline(plait_store* store, const char* name,
                                                const char* pipeline);
/* Removes attribute `name`. Attribute `replacement` gets its name. */
PLAIT_API plait_status plait_store_replace_attribute(plait_store* store, const char* name,
                                                     const char* replacement);
/* Removes an attribute with its levels. PLAIT_ERROR_BAD_STATE if levels of another attribute are
 * encoded from its levels. */
PLAIT_API plait_status plait_store_remove_attribute(plait_store* store, const char* name);
/* Encodes all levels of an attribute anew with another pipeline, or with several, as
 * plait_store_set_pipeline() takes them. The records do not change. Until the next commit, the old
 * and the new levels take disk space. */
PLAIT_API plait_status plait_store_recode_attribute(plait_store* store, const char* name,
                                                    const char* pipeline);
/* The records of the base vertices, for reading. Valid until the next call that changes the
 * attributes of the store. An output may be NULL, here and in the next call. */
PLAIT_API plait_status plait_store_get_base_records(const plait_store* store, const char* name,
                                                    const void** records, uint64_t* count);
/* The same, for writing. The program writes before it opens a reader. The next commit publishes
 * what the program has written. */
PLAIT_API plait_status plait_store_edit_base_records(plait_store* store, const char* name,
                                                     void** records, uint64_t* count);

/* ---- Work on a whole store ---- */

/* Options of plait_store_subdivide(). */
typedef struct plait_subdivide_options {
  size_t struct_size;
  const char* scheme;      /* "loop", "butterfly" or "midpoint"; NULL: "loop" */
  const char* executor;    /* "auto", "fused", "sweep" or "transparent"; NULL: "auto" */
  plait_progress progress; /* may be NULL */
  plait_warning warn;      /* NULL: nobody is told that float32 is too coarse for the levels */
  void* user;              /* for `progress` and `warn` */
  int32_t levels;          /* the level to reach */
  int32_t threads;         /* 0: all processors */
  int32_t normals;         /* 1: also makes attribute "normal": float32 x 3, unit length */
  int32_t limit;           /* 1: projects positions to the limit surface */
  int32_t commit_levels;   /* 1: commits when a level is complete; not with "fused" */
  int32_t reserved;        /* 0 */
} plait_subdivide_options;
#define PLAIT_SUBDIVIDE_OPTIONS_INIT \
  { sizeof(plait_subdivide_options), NULL, NULL, NULL, NULL, NULL, 1, 1, 0, 0, 0, 0 }
/* Refines attribute "position" from its finest level to `levels`. Does not commit at the end.
 * Errors before the first change: INVALID_ARGUMENT; NOT_SUPPORTED (limit positions of a scheme
 * without them; "fused" in a store that has levels); BUDGET with the budget that the whole work
 * needs; BAD_STATE, also if positions are unfinished. After any later error (CANCELLED, IO,
 * NO_SPACE), call plait_store_roll_back(): until then nobody can read what is unfinished, or commit
 * the store. */
PLAIT_API plait_status plait_store_subdivide(plait_store* store,
                                             const plait_subdivide_options* options);

#define PLAIT_DIGEST_BYTES 33
#define PLAIT_ALL_LEVELS (-1)
/* Writes 32 hexadecimal digits and a zero byte to `text`. They depend on all records of a level, or
 * of all levels, and not on backend, layout or executor. `progress` may be NULL. */
PLAIT_API plait_status plait_store_digest(plait_store* store, int32_t level, int32_t threads,
                                          plait_progress progress, void* user,
                                          char text[PLAIT_DIGEST_BYTES]);

/* Computes where the patches are (plait_reader_faces_in_box), and writes it to a file of the store.
 * `attribute` is float32 x 3 or float64 x 3; NULL stands for "position". `progress` may be NULL,
 * and counts bytes of levels that are read. Errors: NOT_SUPPORTED for a store in memory; BAD_STATE
 * for changes that are not committed; BUSY while another handle or process writes a store that this
 * one reads; CANCELLED, IO, NO_SPACE: then nothing has changed. */
PLAIT_API plait_status plait_store_write_bounds(plait_store* store, const char* attribute,
                                                plait_progress progress, void* user);

/* A block that plait_store_verify() found damaged. */
typedef struct plait_damaged_block {
  size_t struct_size;
  const char* attribute;
  const char* reason;
  uint64_t block;
  uint64_t file_offset;
  uint32_t first_edge;
  uint32_t edge_after;
  int32_t level;
  int32_t reserved;
} plait_damaged_block;
/* What plait_store_verify() found. */
typedef struct plait_verify_report {
  size_t struct_size;
  uint64_t blocks, bytes; /* read and checked */
  uint64_t never_written; /* blocks that read as zeros */
  uint64_t damaged_count;
} plait_verify_report;
#define PLAIT_VERIFY_REPORT_INIT \
  { sizeof(plait_verify_report), 0, 0, 0, 0 }
/* Told of a damaged block. The block is valid during the call. */
typedef void (*plait_damage)(const plait_damaged_block* block, void* user);
/* Reads every block of the store and compares its checksum. Damage is no error of the call: it is
 * in the report. At the end `damage` is told of the first 1,000 damaged blocks. `progress`,
 * `damage` and `report` may be NULL. */
PLAIT_API plait_status plait_store_verify(plait_store* store, plait_progress progress,
                                          plait_damage damage, void* user,
                                          plait_verify_report* report);

/* ---- Readers ---- */

enum {
  PLAIT_EVICTION_CLOCK = 0,       /* for patches in random order */
  PLAIT_EVICTION_LAYOUT_ORDER = 1 /* for faces that ascend */
};
/* Options of plait_reader_open(). */
typedef struct plait_reader_options {
  size_t struct_size;
  const char* const* attributes; /* names; NULL: all attributes of the store */
  uint64_t attribute_count;
  uint64_t
      share_bytes;  /* the part of the store's budget that the reader counts on; 0: equal parts */
  int32_t eviction; /* PLAIT_EVICTION_... */
  int32_t reserved; /* 0 */
} plait_reader_options;
#define PLAIT_READER_OPTIONS_INIT \
  { sizeof(plait_reader_options), NULL, 0, 0, PLAIT_EVICTION_CLOCK, 0 }
PLAIT_API plait_status plait_reader_open(const plait_store* store,
                                         const plait_reader_options* options,
                                         plait_reader** reader);
/* Ends the handle. Its views stay valid. Does nothing for NULL. */
PLAIT_API void plait_reader_close(plait_reader* reader);

/* Pins all records of face `face` at `level`, of all attributes of the reader, until the program
 * releases the view. Views take memory of the budget.
 * Errors: INVALID_ARGUMENT for a face or a level that is not there; BUDGET with the number of open
 * views; IO, CORRUPTION. */
PLAIT_API plait_status plait_reader_read_patch(const plait_reader* reader, uint32_t face,
                                               int32_t level, plait_view** view);
/* Told of one patch. The library ends the view after the call. Returns 0 to cancel the work. */
typedef int (*plait_visit_patch)(const plait_view* view, void* user);
/* Calls `visit` for these faces, in this order, and reads the next patches ahead. */
PLAIT_API plait_status plait_reader_visit_patches(const plait_reader* reader, const uint32_t* faces,
                                                  uint64_t face_count, int32_t level,
                                                  plait_visit_patch visit, void* user);
/* Begins to read these patches, which the program will read soon: those in front first, as far as
 * the budget and the I/O threads have room now, and 64 at most. Sets *begun, which may be NULL, to
 * the number of patches that are in memory or on their way; call it again with the others later.
 * The blocks stay in memory until the patch is read, or until plait_reader_end_prefetch(). */
PLAIT_API plait_status plait_reader_prefetch(const plait_reader* reader, const uint32_t* faces,
                                             uint64_t face_count, int32_t level, uint64_t* begun);
/* The program does not need the patches that it has not read since. */
PLAIT_API plait_status plait_reader_end_prefetch(const plait_reader* reader);
/* The faces whose bounds meet the box or touch it, ascending. The bounds of a face contain all
 * vertices of its patch. `low` and `high` have three numbers each; they may be infinite.
 * `attribute` is float32 x 3 or float64 x 3, and one that the reader reads; NULL stands for
 * "position". Sets *face_count, and fills `faces` unless it is NULL. `capacity` is the room of
 * `faces`. The first call reads a file that plait_store_write_bounds() has written, or else all
 * levels of the attribute. Errors: INVALID_ARGUMENT, also if the room is too small; CORRUPTION, IO.
 */
PLAIT_API plait_status plait_reader_faces_in_box(const plait_reader* reader, const char* attribute,
                                                 const double* low, const double* high,
                                                 uint32_t* faces, uint64_t capacity,
                                                 uint64_t* face_count);
/* The faces whose bounds a ray meets, the nearest first. `origin` and `direction` have three finite
 * numbers each. A distance tells how far from its origin the ray enters the bounds of the face, in
 * lengths of the direction. `faces` and `distances` may be NULL, and have room for `capacity`
 * numbers. All else is as above. */
PLAIT_API plait_status plait_reader_faces_along_ray(const plait_reader* reader,
                                                    const char* attribute, const double* origin,
                                                    const double* direction, uint32_t* faces,
                                                    double* distances, uint64_t capacity,
                                                    uint64_t* face_count);
/* The triangles of a patch: three places in row order for each, counterclockwise. They are the same
 * for all patches of a level. Sets *triangle_count, and fills `indices` unless it is NULL.
 * `capacity` is the room of `indices` in triangles. Errors: INVALID_ARGUMENT if the room is too
 * small. */
PLAIT_API plait_status plait_reader_patch_indices(const plait_reader* reader, int32_t level,
                                                  uint32_t* indices, uint64_t capacity,
                                                  uint64_t* triangle_count);

/* The number of vertices that `level` creates; for the base level, of the base vertices. */
PLAIT_API plait_status plait_reader_vertex_count(const plait_reader* reader, int32_t level,
                                                 uint64_t* count);
/* Copies the records of the vertices `first` to `first` + `count` - 1 of those that `level`
 * creates. Vertices are in the order of the files: base vertices by number, others in slot order.
 * `bytes` is the size of `records`: `count` times the bytes of a record. */
PLAIT_API plait_status plait_reader_read_vertices(const plait_reader* reader, const char* name,
                                                  int32_t level, uint64_t first, uint64_t count,
                                                  void* records, uint64_t bytes);
/* Records of `count` vertices, in memory during the call. Returns 0 to cancel the work. */
typedef int (*plait_visit_records)(const void* records, uint64_t first, uint64_t count, void* user);
/* The same records without a copy, block by block. */
PLAIT_API plait_status plait_reader_visit_vertices(const plait_reader* reader, const char* name,
                                                   int32_t level, uint64_t first, uint64_t count,
                                                   plait_visit_records visit, void* user);
/* Views of the reader's store that have not ended, of all of its readers. */
PLAIT_API plait_status plait_reader_view_count(const plait_reader* reader, uint64_t* count);
PLAIT_API plait_status plait_reader_get_statistics(const plait_reader* reader,
                                                   plait_paging_statistics* statistics);

/* ---- Views ---- */

/* What a view shows. */
typedef struct plait_view_info {
  size_t struct_size;
  uint64_t vertex_count; /* (size + 1)(size + 2) / 2 */
  int64_t size;          /* steps along a side: corners are (0, 0), (size, 0) and (0, size) */
  uint32_t face;
  int32_t level;
} plait_view_info;
#define PLAIT_VIEW_INFO_INIT \
  { sizeof(plait_view_info), 0, 0, 0, 0 }
PLAIT_API plait_status plait_view_get_info(const plait_view* view, plait_view_info* info);
/* The record at a point of the patch, with i >= 0, j >= 0 and i + j <= size. The program must not
 * change it. Valid until the view ends. */
PLAIT_API plait_status plait_view_at(const plait_view* view, const char* name, int64_t i, int64_t j,
                                     const void** record);
/* Copies all records in row order: (0, 0), (1, 0), ..., (size, 0), (0, 1), ..., (0, size). `bytes`
 * is the size of `records`: vertex_count times the bytes of a record. */
PLAIT_API plait_status plait_view_copy(const plait_view* view, const char* name, void* records,
                                       uint64_t bytes);
/* Ends a view of plait_reader_read_patch(). Does nothing for NULL. */
PLAIT_API void plait_view_release(plait_view* view);

/* ---- Patch writers ---- */

#define PLAIT_OUTERMOST_LEVEL (-1)
/* Options of plait_patch_writer_open(). */
typedef struct plait_patch_writer_options {
  size_t struct_size;
  const char* const* attributes; /* names; NULL: all attributes of the store */
  uint64_t attribute_count;
  uint64_t share_bytes; /* of blocks that are held between two calls; 0: 3/4 of the budget */
  int32_t first_level;  /* the levels to fill; PLAIT_OUTERMOST_LEVEL: from the base level on, up */
  int32_t last_level;   /* to the finest level of each attribute */
  int32_t compare;      /* 1: refuses a record that differs from that of another patch */
  int32_t reserved;     /* 0 */
} plait_patch_writer_options;
#define PLAIT_PATCH_WRITER_OPTIONS_INIT                                                           \
  {                                                                                               \
    sizeof(plait_patch_writer_options), NULL, 0, 0, PLAIT_OUTERMOST_LEVEL, PLAIT_OUTERMOST_LEVEL, \
        0, 0                                                                                      \
  }
/* Begins to fill levels of a store, patch by patch. Every patch of these levels must be written;
 * until plait_patch_writer_finish(), nobody can read the levels, and plait_store_commit() fails and
 * names a face that nobody wrote. Any number of threads may write patches with one writer, in any
 * order; no two of them the same face of the same attribute at the same time. Meanwhile no call may
 * change the store. Errors: NOT_FOUND for an attribute, INVALID_ARGUMENT for levels that are not
 * there; NOT_SUPPORTED for committed levels that are encoded from others (write to another
 * attribute, then use plait_store_replace_attribute()); BAD_STATE for a store that was opened for
 * reading; BUSY. */
PLAIT_API plait_status plait_patch_writer_open(plait_store* store,
                                               const plait_patch_writer_options* options,
                                               plait_patch_writer** writer);
/* Writes a patch at `level` with all coarser levels of the writer. `records` are in the order of
 * plait_view_copy(), and `bytes` is their size. A vertex on an edge is in the patches of two faces:
 * the record of the face that owns the edge is kept. Errors: INVALID_ARGUMENT, with `compare` also
 * for two different records of a vertex: the message has the faces, the place and the records;
 * NOT_FOUND for an attribute; BUDGET, IO, NO_SPACE. */
PLAIT_API plait_status plait_patch_writer_write_patch(plait_patch_writer* writer, const char* name,
                                                      uint32_t face, int32_t level,
                                                      const void* records, uint64_t bytes);
/* The same for only the vertices that `level` creates. `records` has the whole patch, but those of
 * coarser levels are not read. */
PLAIT_API plait_status plait_patch_writer_write_level(plait_patch_writer* writer, const char* name,
                                                      uint32_t face, int32_t level,
                                                      const void* records, uint64_t bytes);
/* Ends the work: the levels can be read and committed, and the writer writes no more. Errors:
 * BAD_STATE if a patch is missing: the message names it, and the program may still write it; also
 * for a second call after one that succeeded. */
PLAIT_API plait_status plait_patch_writer_finish(plait_patch_writer* writer);
PLAIT_API plait_status plait_patch_writer_get_statistics(const plait_patch_writer* writer,
                                                         plait_paging_statistics* statistics);
/* Ends the handle. Without plait_patch_writer_finish() the levels stay unfinished. Does nothing for
 * NULL. */
PLAIT_API void plait_patch_writer_close(plait_patch_writer* writer);

/* ---- Arrays: many patches, many vertices, and records where they are ---- */

/* Copies the records of one attribute of these faces: patch after patch, each in row order. The
 * reader reads the next patches ahead. `bytes` is the size of `records`: for each face, the
 * vertices of a patch times the bytes of a record. Errors: those of plait_reader_read_patch();
 * INVALID_ARGUMENT. */
PLAIT_API plait_status plait_reader_copy_patches(const plait_reader* reader, const char* name,
                                                 const uint32_t* faces, uint64_t face_count,
                                                 int32_t level, void* records, uint64_t bytes);
/* Numbers the vertices of these patches from 0 on, each vertex once, though patches share the
 * vertices of their common sides. The number of the vertex at place p of patch k is written to
 * numbers[k * (vertices of a patch) + p]. Numbers ascend in the order in which vertices first
 * appear. `capacity` is the room of `numbers`: the vertices of all patches. Sets *vertex_count.
 * Errors: INVALID_ARGUMENT, also for a face that is named twice, and for more than 2^32 - 1 places.
 */
PLAIT_API plait_status plait_reader_weld_patches(const plait_reader* reader, const uint32_t* faces,
                                                 uint64_t face_count, int32_t level,
                                                 uint32_t* numbers, uint64_t capacity,
                                                 uint64_t* vertex_count);

/* The first vertex of each block of a level, ascending: ranges that a program reads best in one
 * call. The base level is one block. Sets *block_count, and fills `firsts` unless it is NULL.
 * `capacity` is the room of `firsts`. Errors: NOT_FOUND; INVALID_ARGUMENT, also if the room is too
 * small. */
PLAIT_API plait_status plait_reader_get_blocks(const plait_reader* reader, const char* name,
                                               int32_t level, uint64_t* firsts, uint64_t capacity,
                                               uint64_t* block_count);

typedef struct plait_pin plait_pin; /* records that stay at their addresses in memory */
/* Pins the records of the vertices `first` to `first` + `count` - 1 of those that `level` creates
 * where the store has them in memory, without a copy: as many as lie one after another, one block
 * at least. Sets *pin, *records and *pinned_count. The program must not change the records. A pin
 * counts as a view, and stays valid when reader and store end. Errors: NOT_SUPPORTED if the store
 * has no addresses: they are those of backend "memory", and of "mmap" in a store opened for
 * reading; INVALID_ARGUMENT, also for a count of 0. */
PLAIT_API plait_status plait_reader_pin_vertices(const plait_reader* reader, const char* name,
                                                 int32_t level, uint64_t first, uint64_t count,
                                                 plait_pin** pin, const void** records,
                                                 uint64_t* pinned_count);
/* Ends a pin. Does nothing for NULL. */
PLAIT_API void plait_pin_release(plait_pin* pin);

enum {
  PLAIT_ACCESS_UPDATE = 0,    /* the callback reads the old records and changes them */
  PLAIT_ACCESS_OVERWRITE = 1, /* the callback writes every record; the old ones are not read */
  PLAIT_ACCESS_READ = 2       /* the callback changes nothing */
};
/* An attribute that plait_store_visit() gives to its callback. */
typedef struct plait_visit_attribute {
  const char* name;
  int32_t access; /* PLAIT_ACCESS_... */
  int32_t rings;  /* 1, with PLAIT_ACCESS_READ: also the neighbours of each vertex */
} plait_visit_attribute;
/* The records of one attribute in a batch. */
typedef struct plait_batch_records {
  /* `count` records. With PLAIT_ACCESS_OVERWRITE they are zeros at first. */
  void* records;
  /* count * valence records: the neighbours of the first vertex, counterclockwise, then those of
   * the next one; NULL unless the visit reads rings of the attribute. */
  const void* neighbours;
} plait_batch_records;
/* Vertices with equally many neighbours, and all their records. Valid during the call. */
typedef struct plait_vertex_batch {
  size_t struct_size;
  uint64_t count;
  const int32_t* levels;  /* [count] the level that creates the vertex */
  const uint64_t* places; /* [count] its number, as plait_reader_read_vertices() counts */
  const plait_batch_records* attributes; /* in the order of the call */
  uint64_t attribute_count;
  int32_t valence; /* neighbours of each vertex at the finest level of the visit; 0 without rings */
  int32_t border;  /* 1: all are on a border, and their first and last neighbours too; 0: none is */
  int32_t base;    /* 1: all are base vertices; 0: none is */
  int32_t reserved; /* 0 */
} plait_vertex_batch;
/* Computes on a batch. Returns 0 to cancel the work. */
typedef int (*plait_visit_batch)(const plait_vertex_batch* batch, void* user);
#define PLAIT_FINEST_LEVEL (-1)
/* Gives every vertex of the levels `first_level` to `level` to `visit` once, in batches of about
 * 65,000 vertices, in one pass over the files. 0 and PLAIT_FINEST_LEVEL are all levels; twice the
 * same number is one level. The other levels stay as they are. The base mesh alone decides which
 * neighbour of an inner vertex is the first. With PLAIT_FINEST_LEVEL the attributes must have
 * equally many levels. A pass that reads rings of an attribute writes to another one; no attribute
 * may be named twice. Neither `visit` nor `progress` may call functions that change the store.
 * `progress` may be NULL, and counts vertices. Errors: NOT_FOUND, INVALID_ARGUMENT, BAD_STATE for a
 * store that was opened for reading, BUDGET with the budget that the pass needs, CANCELLED. After
 * an error in the pass, the levels that it writes are unfinished: they cannot be read or committed
 * until a later pass has overwritten them, or plait_store_roll_back(). */
PLAIT_API plait_status plait_store_visit(plait_store* store,
                                         const plait_visit_attribute* attributes,
                                         uint64_t attribute_count, int32_t first_level,
                                         int32_t level, plait_visit_batch visit,
                                         plait_progress progress, void* user);

/* ---- What a browser reads of a store ---- */

typedef struct plait_served plait_served; /* the files that the page and its viewer read */
/* A file of it. Texts are valid until the handle ends. */
typedef struct plait_served_file {
  size_t struct_size;
  uint64_t bytes;
  const char* content_type; /* for the header of HTTP with this name */
  const char* tag;          /* for ETag: another one for each version of each store */
} plait_served_file;
#define PLAIT_SERVED_FILE_INIT \
  { sizeof(plait_served_file), 0, NULL, NULL }

/* Makes ready what a browser needs to show the store: the page, the view, and the raw records of
 * all levels, decoded from any backend (docs/on-the-web.md). A program answers requests with it;
 * the library has no server. Reads all positions if the store has no view of its version.
 * `progress` may be NULL, and counts faces. The handle counts as a reader of the store. Errors:
 * INVALID_ARGUMENT for a store whose attribute "position" is not float32 x 3 or float64 x 3;
 * NOT_SUPPORTED if its faces differ in depth; NOT_FOUND without the attribute; BUDGET; CORRUPTION;
 * CANCELLED. */
PLAIT_API plait_status plait_served_open(plait_store* store, plait_progress progress, void* user,
                                         plait_served** served);
/* The file that a browser asks for by this path, such as "/" or "/view". A path is only compared
 * with those that there are: none leads to another file of the disk. Errors: NOT_FOUND. */
PLAIT_API plait_status plait_served_find(const plait_served* served, const char* path,
                                         plait_served_file* file);
/* Reads `count` bytes of the file from `offset` on. Any number of threads may call it at the same
 * time. Errors: NOT_FOUND; INVALID_ARGUMENT for bytes behind the end; CORRUPTION; IO; BUDGET. */
PLAIT_API plait_status plait_served_read(const plait_served* served, const char* path,
                                         uint64_t offset, void* bytes, uint64_t count);
/* Does nothing for NULL. */
PLAIT_API void plait_served_close(plait_served* served);

/* ---- Jobs: whole works by their names ---- */

/* A text that a call has made. */
typedef struct plait_text plait_text;
/* Its characters: UTF-8, with a zero byte at the end. Valid until the text ends. Empty for NULL. */
PLAIT_API const char* plait_text_string(const plait_text* text);
/* Ends a text. Does nothing for NULL. */
PLAIT_API void plait_text_release(plait_text* text);

/* Describes a job, or with NULL all jobs, as JSON: {"name", "summary", "options": [{"name", "kind",
 * "help", "default", "choices", "required", "position"}]}. Errors: INVALID_ARGUMENT for a name that
 * no job has. */
PLAIT_API plait_status plait_job_options(const char* job, plait_text** options);
/* Runs a job: "subdivide", "plan", "part", "join", "import", "remesh", "export", "convert",
 * "publish", "check", "compare", "pass", "generate", "render", as the command of the program with
 * this name does. Its options are those of the command, each a text NAME=VALUE: "levels=5",
 * "compress=@6=fast"; NAME alone for one that the command takes without a value: "normals". What
 * the command takes without a name has the name of its --help in small letters: "input=...",
 * "store=...". Sizes may have a unit: "64MiB". threads=0, the default, stands for all processors.
 * `progress` and `warning` may be NULL. Sets *report to what the job did, a JSON object: that of
 * the command with --json; `report` may be NULL. After an error or a cancel, nothing half-made is
 * left; with the option resume the last commit stays. Errors: INVALID_ARGUMENT for an option that
 * the job does not have, with those that it has, for a value that the option does not take, and for
 * what the job refuses; CANCELLED, BUDGET, OUT_OF_MEMORY before the work, IO, NO_SPACE, and those
 * of reading. */
PLAIT_API plait_status plait_job_run(const char* job, const char* const* options, uint64_t count,
                                     plait_progress progress, plait_warning warning, void* user,
                                     plait_text** report);

/* ---- Passes of a program's own, in parts: docs/many-machines.md ----
 *
 * The jobs "plan", "part" and "join" make a store, or a pass over one, in parts. Only a part of a
 * pass of the program's own needs a call of its own, because it has a kernel. The job "plan" plans
 * it: "pass=fold", "result=folded,float32,1", "parameters=2 1". */

/* Fills attribute `into` for all vertices of `store`, by plait_store_visit() with
 * PLAIT_FINEST_LEVEL, which visits those of one part. May read other attributes, and must not
 * change the store otherwise nor keep the handle. Returns PLAIT_OK, or the code of the call that
 * failed. */
typedef plait_status (*plait_pass_kernel)(plait_store* store, const char* into, void* user);

/* Options of plait_parts_make(). */
typedef struct plait_part_options {
  size_t struct_size;
  uint64_t budget_bytes;   /* PLAIT_DEFAULT_BUDGET_BYTES */
  plait_progress progress; /* may be NULL */
  void* user;
  int32_t threads;          /* 1 */
  int32_t again;            /* 1: make the part even if it is done */
  plait_pass_kernel kernel; /* of the program's own pass; else NULL */
  void* kernel_user;
  const char* store; /* of a pass: where this machine sees its store; NULL: as in the plan */
} plait_part_options;
#define PLAIT_PART_OPTIONS_INIT \
  { sizeof(plait_part_options), 0, NULL, NULL, 1, 0, NULL, NULL, NULL }
/* Makes part 0, 1, ... of a plan, unless it is done. `options` may be NULL. Errors:
 * INVALID_ARGUMENT, NOT_FOUND, CORRUPTION, NOT_SUPPORTED (a plan of another version of plait),
 * CANCELLED, BUDGET, IO, NO_SPACE; for a pass also BAD_STATE if the store has another version than
 * the plan, or is a copy that went its own way, and that of the kernel. */
PLAIT_API plait_status plait_parts_make(const char* plan_path, uint32_t part,
                                        const plait_part_options* options);

#ifdef __cplusplus
}
#endif

#endif
