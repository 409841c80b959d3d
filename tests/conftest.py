import flexmb as fm

fm.enable_x64()
