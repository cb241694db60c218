# How the libraries of the project are declared.

# multitetra_precompiled_set(SET LIBRARIES target... HEADERS header...) parses those headers once, and
# multitetra_precompiled(TARGET SET) takes them. Files include what they use all the same.
function(multitetra_precompiled_set set)
  cmake_parse_arguments(ARG "" "" "LIBRARIES;HEADERS" ${ARGN})
  if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/empty.cpp CONTENT "// For targets that are only precompiled headers.\n")
    add_library(multitetra_precompiled_${set} STATIC ${PROJECT_BINARY_DIR}/empty.cpp)
    target_link_libraries(multitetra_precompiled_${set} PRIVATE multitetra_options ${ARG_LIBRARIES})
    target_precompile_headers(multitetra_precompiled_${set} PRIVATE ${ARG_HEADERS})
  endif()
endfunction()
function(multitetra_precompiled target set)
  if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
    target_precompile_headers(${target} REUSE_FROM multitetra_precompiled_${set})
  endif()
endfunction()
# No JSON: its header costs each file that gets it half a second, used or not.
set(MULTITETRA_STANDARD_HEADERS
  <algorithm> <array> <chrono> <cmath> <cstdint> <filesystem> <functional> <map> <memory> <mutex> <optional> <set> <span>
  <stop_token> <string> <string_view> <utility> <variant> <vector> <tl/expected.hpp>)
multitetra_precompiled_set(standard LIBRARIES tl::expected HEADERS ${MULTITETRA_STANDARD_HEADERS})

# multitetra_library(NAME SOURCES file... [PUBLIC target...] [PRIVATE target...] [HEADERS set])
# Adds the library of one folder. What its headers include is PUBLIC, what only its sources include is
# PRIVATE. HEADERS names the precompiled headers that it takes; "standard" by default.
function(multitetra_library name)
  cmake_parse_arguments(ARG "" "HEADERS" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  if(NOT ARG_SOURCES)
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE multitetra_options ${ARG_PUBLIC})
    return()
  endif()
  if(NOT ARG_HEADERS)
    set(ARG_HEADERS standard)
  endif()
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC multitetra_options ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  multitetra_precompiled(${name} ${ARG_HEADERS})
endfunction()
