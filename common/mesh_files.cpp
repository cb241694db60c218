#include "common/mesh_files.hpp"
