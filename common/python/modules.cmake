# What the modules of the Python package need. For a Python other than Debian's: -DPython_EXECUTABLE=/path/to/python.
set(Python_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "The Python that the package is for")
find_package(Python 3.9 QUIET COMPONENTS Interpreter Development.Module)
find_package(pybind11 QUIET)
set(MULTITETRA_HAS_PYTHON OFF)
if(NOT Python_FOUND OR NOT pybind11_FOUND)
  message(STATUS "The Python package is not built: its packages are missing (bash docker/install.sh python).")
elseif(NOT MULTITETRA_SANITIZE)  # A Python without the sanitizer runtime cannot load the modules.
  set(MULTITETRA_HAS_PYTHON ON)
endif()

# multitetra_python_module(TARGET NAME source...) adds a module of the package, which is assembled in build/PRESET/python.
function(multitetra_python_module target name)
  pybind11_add_module(${target} MODULE NO_EXTRAS ${ARGN})
  set_target_properties(${target} PROPERTIES OUTPUT_NAME ${name} LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/python/multitetra)
endfunction()
