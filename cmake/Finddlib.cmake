# Defines dlib::dlib. The configuration that the Debian package ships names the development files of
# image libraries, which the package does not depend on and powdercal has no use for.
find_path(dlib_INCLUDE_DIR dlib/svm/svr_trainer.h)
find_library(dlib_LIBRARY dlib)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(dlib REQUIRED_VARS dlib_LIBRARY dlib_INCLUDE_DIR)
if(dlib_FOUND AND NOT TARGET dlib::dlib)
  add_library(dlib::dlib UNKNOWN IMPORTED)
  set_target_properties(dlib::dlib PROPERTIES
    IMPORTED_LOCATION "${dlib_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${dlib_INCLUDE_DIR}")
endif()
mark_as_advanced(dlib_INCLUDE_DIR dlib_LIBRARY)
